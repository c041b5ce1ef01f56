use girtin_params::Problem;
use girtin_params::row::Parameters;
use girtin_wash::{C97Params, Capillary, LivingParams};
use proptest::prelude::*;

use super::*;
use crate::document::{EdgeStretch, Fill, FilledFigure, Graded, Stock};
use crate::gallery::{EFFECTS, LIVING, SWATCHES};

fn both(document: &Document) -> [Result<Document, Problem>; 2] {
    let stock = Stock::builtin();
    [
        Document::from_toml("written.toml", &document.to_toml(), &stock),
        Document::from_json("written.json", &document.to_json(), &stock),
    ]
}

fn map(name: String) -> MapName {
    MapName { file: name, ..MapName::default() }
}

fn point() -> impl Strategy<Value = [f64; 2]> {
    [-1e4f64..=1e4, -1e4f64..=1e4]
}

fn shape() -> impl Strategy<Value = Shape> {
    let length = || 0.0f64..=1e4;
    prop_oneof![
        Just(Shape::Everywhere),
        (point(), length()).prop_map(|(center, radius)| Shape::Disc { center, radius }),
        (point(), point()).prop_map(|(from, to)| Shape::Rectangle { from, to }),
        prop::collection::vec(point(), 3..5).prop_map(|points| Shape::Polygon { points }),
        (prop::collection::vec(point(), 1..4), [length(), length()])
            .prop_map(|(points, width)| Shape::Stroke { points, width }),
        "\\PC{0,6}".prop_map(|file| Shape::Map(map(file))),
    ]
}

pub(crate) fn area() -> impl Strategy<Value = Area> {
    let part = || 0.0f64..=1.0;
    (shape(), [part(), part(), part(), part()], 0.01f64..=1e4).prop_map(
        |(shape, [soft_mm, ragged_mm, above, bristles], ragged_scale_mm)| Area {
            shape,
            soft_mm,
            ragged_mm,
            ragged_scale_mm,
            above_height: [above, part_of(above)],
            bristles,
        },
    )
}

/// Another number from 0 to 1.
fn part_of(number: f64) -> f64 {
    number * number
}

fn feed() -> impl Strategy<Value = Feed> {
    (area(), 0.0f64..=100.0, 0.001f64..=1000.0).prop_map(|(area, amount, level)| Feed { area, amount, level })
}

fn ring() -> impl Strategy<Value = Vec<[f64; 2]>> {
    prop::collection::vec(point(), 3..5)
}

fn figure() -> impl Strategy<Value = Figure> {
    prop::collection::vec(ring(), 1..3).prop_map(|rings| Figure { rings })
}

fn fill(pigments: usize, drawn: usize) -> impl Strategy<Value = Event> {
    let amounts = move || prop::collection::vec(0.0f64..=100.0, pigments);
    let graded = (point(), point(), amounts()).prop_map(|(a, b, amounts)| Graded { line: [a, b], amounts });
    let laid = prop::option::of(-360.0f64..=360.0);
    let filled = (0..drawn, amounts(), prop::option::of(graded), any::<u32>(), laid, 0.0f64..=1.0).prop_map(
        |(figure, amounts, graded, family, laid_degrees, held)| FilledFigure {
            figure,
            amounts,
            graded,
            family,
            laid_degrees,
            held,
        },
    );
    let edge = (prop::collection::vec(point(), 1..3), 0.0f64..=9.0, 0.0f64..=9.0)
        .prop_map(|(path, lost_mm, dry_mm)| EdgeStretch { path, lost_mm, dry_mm });
    let numbers = (0.0f64..=100.0, 0.0f64..=1.0, 0.0f64..=1.0, 0.1f64..=1000.0, 0.0f64..=2.0);
    (prop::collection::vec(filled, 0..3), prop::collection::vec(edge, 0..2), numbers).prop_map(
        |(figures, edges, (water, uneven, charged, uneven_scale_mm, rim))| {
            Event::Fill(Fill { figures, edges, water, uneven, charged, uneven_scale_mm, rim })
        },
    )
}

fn mark(pigments: usize) -> impl Strategy<Value = Mark> {
    let amounts = move || prop::collection::vec(0.0f64..=100.0, pigments);
    let path = prop::collection::vec((point(), 0.0f64..=1000.0), 1..4);
    let numbers = ([0.0f64..=2.0, 0.0f64..=2.0, 0.0f64..=2.0], [0.0f64..=99.0, 0.0f64..=99.0]);
    let shape = (-0.5f64..=0.5, prop::option::of(-80.0f64..=80.0), 0.0f64..=10.0, 0.0f64..=1.0);
    (path, numbers, shape, amounts(), prop::option::of(amounts())).prop_map(
        |(path, (dry, drag), (side, chisel_degrees, bead, scraped), amounts, end_amounts)| {
            let (path, widths) = path.into_iter().unzip();
            let bristles = dry.map(|x| 3.0 * x);
            Mark {
                path,
                widths,
                side,
                chisel_degrees,
                dry,
                bristles,
                drag,
                amounts,
                end_amounts,
                bead,
                scraped,
            }
        },
    )
}

fn event(pigments: usize, is_living: bool, drawn: usize) -> impl Strategy<Value = Event> {
    let amounts = || prop::collection::vec(0.0f64..=100.0, pigments);
    let part = || 0.0f64..=1.0;
    // Without a drawing there is nothing to fill.
    let filled = fill(pigments, drawn.max(1)).prop_map(move |event| match event {
        Event::Fill(fill) if drawn == 0 => Event::Fill(Fill { figures: Vec::new(), ..fill }),
        event => event,
    });
    prop_oneof![
        filled,
        (prop::collection::vec(mark(pigments), 0..3), 0.0f64..=2.0)
            .prop_map(|(marks, rim)| Event::Marks { marks, rim }),
        area().prop_map(|area| Event::Wet { area }),
        (area(), -100.0f64..=100.0).prop_map(|(area, amount)| Event::Water { area, amount }),
        (area(), amounts()).prop_map(|(area, amounts)| Event::Pigment { area, amounts }),
        (area(), 0.0f64..=100.0, amounts()).prop_map(|(area, water, amounts)| Event::Brush {
            area,
            water,
            amounts
        }),
        (area(), 0.0f64..=100.0).prop_map(|(area, volumes)| Event::Moisten { area, volumes }),
        (area(), part()).prop_map(|(area, fraction)| Event::Blot { area, fraction }),
        (area(), part()).prop_map(|(area, fraction)| Event::Lift { area, fraction }),
        (0.0f64..=90.0, -360.0f64..=360.0).prop_map(move |(degrees, toward)| if is_living {
            Event::Tilt { degrees, toward }
        } else {
            Event::Dry { area: None, damp: [0.0; 2] }
        }),
        (0u32..=1_000_000, any::<bool>(), prop::option::of(feed())).prop_map(
            move |(steps, until_dry, feed)| Event::Run { steps, until_dry: until_dry && is_living, feed }
        ),
        area().prop_map(|area| Event::Dry { area: Some(area), damp: [0.0; 2] }),
        [-2.0f64..=2.0, -2.0f64..=2.0].prop_map(|damp| Event::Dry { area: None, damp }),
    ]
}

/// Parameters, each a part of the way from its least to its largest value.
fn parameters<P: Parameters>(part: f64) -> P {
    let mut parameters = P::default();
    for row in P::ROWS {
        let (low, high) = row.hard;
        let value = match row.default {
            girtin_params::Value::Real(_) => girtin_params::Value::Real(low + part * (high - low)),
            girtin_params::Value::Count(_) => girtin_params::Value::Count((low + part * (high - low)) as u32),
            girtin_params::Value::Span(_) => girtin_params::Value::Span([low, low + part * (high - low)]),
        };
        parameters.set(row.id, value).unwrap();
    }
    parameters
}

fn glaze(drawn: usize) -> impl Strategy<Value = Glaze> {
    let names = || "[a-z0-9./]{1,8}";
    let outline = (names(), prop::option::of(names()), prop::option::of(names())).prop_map(
        |(regions, edges, masked)| Outline {
            regions: map(regions),
            edges: edges.map(map),
            masked: masked.map(map),
        },
    );
    let pigments = ["french-ultramarine", "burnt-umber", "cobalt-blue"];
    (0usize..=3, any::<bool>(), any::<bool>(), 0.0f64..=1.0).prop_flat_map(
        move |(count, is_living, has_layer, part)| {
            let outline = prop::option::of(outline.clone());
            let events = prop::collection::vec(event(count, is_living, drawn), 0..4);
            let model = if is_living {
                WashModel::Living(parameters::<LivingParams>(part))
            } else {
                let capillary = has_layer.then(|| parameters::<Capillary>(part));
                WashModel::C97 { params: parameters::<C97Params>(part), capillary }
            };
            ("\\PC{0,8}", outline, events).prop_map(move |(name, outline, events)| Glaze {
                name,
                pigments: pigments[..count].iter().map(ToString::to_string).collect(),
                model,
                granulation: 1.5 * part,
                outline,
                events,
            })
        },
    )
}

fn color() -> impl Strategy<Value = LinearRgb> {
    prop_oneof![
        any::<[u8; 3]>().prop_map(|bytes| Srgb::from_bytes(bytes).to_linear()),
        [0.0f64..=1.0, 0.0f64..=1.0, 0.0f64..=1.0].prop_map(LinearRgb),
    ]
}

fn sheet() -> impl Strategy<Value = SheetSettings> {
    let printed = prop::collection::vec((color(), area()), 0..3);
    let cells = prop::option::of(1.0f64..=8.0);
    let size = [0.1f64..=2000.0, 0.1f64..=2000.0];
    (size, any::<u64>(), color(), printed, (0.01f64..=100.0, 1u32..=8), (cells, 0.0f64..0.49, 0.0f64..=1.0))
        .prop_map(
            |(size_mm, seed, ground, printed, (pixels_per_mm, cells_per_pixel), (cells, trim, relief_mm))| {
                let trim_mm = if cells.is_some() { trim * size_mm[0].min(size_mm[1]) } else { 0.0 };
                SheetSettings {
                    size_mm,
                    paper: "rough".to_owned(),
                    seed,
                    ground,
                    printed,
                    pixels_per_mm,
                    cells_per_pixel,
                    cells_per_mm: cells,
                    trim_mm,
                    relief_mm,
                }
            },
        )
}

/// Any document that a file can hold.
fn document() -> impl Strategy<Value = Document> {
    prop::collection::vec(figure(), 0..3).prop_flat_map(|drawing| {
        let glazes = prop::collection::vec(glaze(drawing.len()), 0..3);
        ("\\PC{0,8}", sheet(), glazes).prop_map(move |(title, sheet, glazes)| Document {
            title,
            sheet,
            drawing: drawing.clone(),
            glazes,
        })
    })
}

proptest! {
    #[test]
    fn what_is_written_is_read_again(document in document()) {
        for read in both(&document) {
            prop_assert_eq!(&read.unwrap(), &document);
        }
    }
}

#[test]
fn the_gallery_is_written_and_read_again() {
    for example in EFFECTS.iter().chain(&LIVING).chain([&SWATCHES]) {
        let document = Document::from_toml(example.name, example.text, &Stock::builtin()).unwrap();
        for read in both(&document) {
            assert_eq!(read.unwrap(), document, "{}", example.name);
        }
    }
}

#[test]
fn bytes_of_color_stay_short_and_other_light_exact() {
    let mut document = Document::from_toml(
        "",
        "format = 1\n[sheet]\nsize = [3, 2]\nground = '#fcfaf5'\n",
        &Stock::builtin(),
    )
    .unwrap();
    assert!(document.to_toml().contains("ground = \"#fcfaf5\"\n"));
    document.sheet.ground = LinearRgb([0.1, 0.25, 1.0 / 3.0]);
    assert!(document.to_json().contains("\"ground\": { \"linear\": [0.1, 0.25, 0.3333333333333333] }"));
}

#[test]
fn unknown_keys_of_json_get_the_nearest_name_and_their_place() {
    let text = "{\n  \"format\": 1,\n  \"sheet\": { \"size\": [3, 2], \"pape\": \"rough\" }\n}\n";
    let problem = Document::from_json("d.json", text, &Stock::builtin()).unwrap_err();
    assert_eq!(problem.to_string(), "d.json:3:30: unknown key `sheet.pape`");
    assert_eq!(problem.hint.as_deref(), Some("did you mean `paper`?"));
}

#[test]
fn every_map_is_named_in_order() {
    let text = "format = 1\n[sheet]\nsize = [3, 2]\n[[sheet.printed]]\narea = { shape = 'map', file = 'a' }\n\
        [[glaze]]\n[glaze.outline]\nregions = 'b'\nmasked = 'c'\n\
        [[glaze.events]]\ndo = 'wet'\narea = { shape = 'map', file = 'd' }\n\
        [[glaze.events]]\ndo = 'run'\nsteps = 3\nfeed = { amount = 1, area = { shape = 'map', file = 'e' } }\n\
        [[glaze.events]]\ndo = 'dry'\narea = { shape = 'map', file = 'b' }\n";
    let mut document = Document::from_toml("", text, &Stock::builtin()).unwrap();
    let names: String = document.map_names_mut().map(|name| name.file.as_str()).collect();
    assert_eq!(names, "abcdeb");
}
