//! The document: a sheet, and glazes as logs of what the painter did.
//!
//! Lengths are millimetres of paper and times reference steps; of cells it only says how many make a pixel. The same TOML
//! holds the gallery's recipes and anybody's own paintings:
//!
//! ```
//! use girtin_painting::{Document, Stock};
//!
//! let text = r#"
//! format = 1
//! title = "A disc"
//! [sheet]
//! size = [30, 20]
//! paper = "cold-press"
//! [[glaze]]
//! pigments = ["cerulean-blue"]
//! [[glaze.events]]
//! do = "wet"
//! area = { shape = "disc", center = [15, 10], radius = 8 }
//! [[glaze.events]]
//! do = "water"
//! amount = 0.6
//! [[glaze.events]]
//! do = "pigment"
//! amounts = [0.4]
//! [[glaze.events]]
//! do = "run"
//! steps = 60
//! "#;
//! let document = Document::from_toml("disc.toml", text, &Stock::builtin())?;
//! assert_eq!(document.glazes[0].steps(), 60);
//! # Ok::<(), girtin_params::Problem>(())
//! ```

use std::collections::BTreeSet;

use girtin_optics::{Library, LinearRgb, Srgb};
use girtin_paper::Papers;
use girtin_params::read::Fault;
use girtin_params::{Place, Problem, Table, parse, parse_json};
use girtin_wash::{Ledger, WashModel};

use crate::area::{Area, Shape};
use crate::wash_settings::read_model;

mod figures;
mod write;

use figures::read_amounts;
pub use figures::{EdgeStretch, Figure, Fill, FilledFigure, Graded, MAX_FIGURES, Mark};

/// Version of the format that this library writes about and reads.
pub const FORMAT: u32 = 1;

/// Longest side of a sheet, millimetres: the largest watercolor sheet made is about 1.5 m.
const MAX_SIDE_MM: f64 = 2000.0;
/// Most steps of one event.
const MAX_STEPS: u32 = 1_000_000;

/// The pigments and papers that a document may name.
#[derive(Clone, Debug)]
pub struct Stock {
    /// Pigments.
    pub pigments: Library,
    /// Papers.
    pub papers: Papers,
}

impl Stock {
    /// What Girtin comes with.
    pub fn builtin() -> Self {
        Self { pigments: Library::builtin(), papers: Papers::builtin() }
    }
}

/// A painting as it was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// Title.
    pub title: String,
    /// What is painted on.
    pub sheet: SheetSettings,
    /// Contours that washes fill, in the order in which they are drawn.
    pub drawing: Vec<Figure>,
    /// Glazes from the paper up.
    pub glazes: Vec<Glaze>,
}

/// What is painted on, and how finely it is simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct SheetSettings {
    /// Width and height, mm.
    pub size_mm: [f64; 2],
    /// Name of the paper.
    pub paper: String,
    /// Seed of the paper's grain and of ragged edges.
    pub seed: u64,
    /// Color of the bare sheet.
    pub ground: LinearRgb,
    /// What is printed on it, in order.
    pub printed: Vec<(LinearRgb, Area)>,
    /// Pixels of the picture a millimetre.
    pub pixels_per_mm: f64,
    /// Samples along each side of a pixel, cells unless [`SheetSettings::cells_per_mm`] says otherwise; the picture is
    /// their mean, so that edges are smooth.
    pub cells_per_pixel: u32,
    /// Cells a millimetre that are simulated, whatever the picture's resolution: it is then developed from them, edges
    /// and grain as fine as it shows them. `None`: as many as there are samples.
    pub cells_per_mm: Option<f64>,
    /// How much of the sheet is cut off on every side after painting, mm.
    pub trim_mm: f64,
    /// Depth of the paper's relief under raking light, mm; 0 shows none.
    pub relief_mm: f64,
}

/// One wash with its pigments, dried before the next.
#[derive(Clone, Debug, PartialEq)]
pub struct Glaze {
    /// Name; may be empty.
    pub name: String,
    /// Ids of the pigments.
    pub pigments: Vec<String>,
    /// Physics.
    pub model: WashModel,
    /// How much more or less than their own granulation the pigments show.
    pub granulation: f64,
    /// What it is confined to; `None`: the whole sheet.
    pub outline: Option<Outline>,
    /// What was done, in order.
    pub events: Vec<Event>,
}

/// The shapes that a glaze is confined to. Water and pigment stay each in their own, and two that abut both end in an
/// edge there, with no paper between.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// A map whose values, in 255ths, tell shapes apart; what is 0 is not painted.
    pub regions: MapName,
    /// A map of how far the middle of each cell is from the edge of its shape, in cells times 16 of 255ths. Without it
    /// edges run between cells. Two shapes that abut where both say 4 cells or more have no edge there: water passes.
    pub edges: Option<MapName>,
    /// A map of masking fluid: 1 stays bare.
    pub masked: Option<MapName>,
}

/// A map as a document names it. Two are equal if the names are, wherever in their files they stand.
#[derive(Clone, Debug, Default)]
pub struct MapName {
    /// Name of the file.
    pub file: String,
    /// Where the document names it.
    pub place: Place,
}

impl PartialEq for MapName {
    fn eq(&self, other: &Self) -> bool {
        self.file == other.file
    }
}

/// One thing a painter does, or lets happen.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// Wets the paper.
    Wet {
        /// Where.
        area: Area,
    },
    /// Adds water where the paper is wet.
    Water {
        /// Where.
        area: Area,
        /// How much.
        amount: f64,
    },
    /// Adds pigment where the paper is wet.
    Pigment {
        /// Where.
        area: Area,
        /// How much of each of the glaze's pigments.
        amounts: Vec<f64>,
    },
    /// A mark of a loaded brush: wets the paper, and adds water, less of it along the edge, and pigment.
    Brush {
        /// Where.
        area: Area,
        /// How deep a film.
        water: f64,
        /// How much of each of the glaze's pigments.
        amounts: Vec<f64>,
    },
    /// Fills figures of the drawing, all of them one wet shape.
    Fill(Fill),
    /// Marks of a brush, united: where two lie over each other paint lies once.
    Marks {
        /// The marks.
        marks: Vec<Mark>,
        /// How strongly paint gathers along their edges, 0 to 2.
        rim: f64,
    },
    /// Moistens the paper: pores fill, and what they cannot hold stands as film.
    Moisten {
        /// Where.
        area: Area,
        /// How much, in volumes of the pores.
        volumes: f64,
    },
    /// Blots film, the pigment in it, and pore water.
    Blot {
        /// Where.
        area: Area,
        /// How much of what is there, 0 to 1.
        fraction: f64,
    },
    /// Leans the board from now on.
    Tilt {
        /// How steeply, degrees.
        degrees: f64,
        /// Where down is, degrees: 0 to the right, 90 to the bottom.
        toward: f64,
    },
    /// Lets the water run.
    Run {
        /// For how many steps.
        steps: u32,
        /// Ends earlier once no film is left.
        until_dry: bool,
        /// Water added before every step.
        feed: Option<Feed>,
    },
    /// Lifts pigment.
    Lift {
        /// Where.
        area: Area,
        /// How much of what is there, 0 to 1.
        fraction: f64,
    },
    /// Lets the wash dry.
    Dry {
        /// Where; without it all of it.
        area: Option<Area>,
        /// Water left in the pores where it was wet: at height 0, and more per height.
        damp: [f64; 2],
    },
}

/// Water that keeps coming while a wash runs, as from a brush held to the paper.
#[derive(Clone, Debug, PartialEq)]
pub struct Feed {
    /// Where.
    pub area: Area,
    /// How much a step.
    pub amount: f64,
    /// The higher the pressure the less is added, and none at this level: a puddle takes only so much.
    pub level: f64,
}

impl Event {
    /// Where it is done, or water is fed.
    fn area_mut(&mut self) -> Option<&mut Area> {
        match self {
            Self::Wet { area }
            | Self::Water { area, .. }
            | Self::Pigment { area, .. }
            | Self::Brush { area, .. }
            | Self::Moisten { area, .. }
            | Self::Blot { area, .. }
            | Self::Lift { area, .. } => Some(area),
            Self::Dry { area, .. } => area.as_mut(),
            Self::Run { feed, .. } => feed.as_mut().map(|feed| &mut feed.area),
            Self::Tilt { .. } | Self::Fill(_) | Self::Marks { .. } => None,
        }
    }
}

impl Area {
    /// The map that it is, if it is one.
    fn map_name_mut(&mut self) -> Option<&mut MapName> {
        match &mut self.shape {
            Shape::Map(name) => Some(name),
            _ => None,
        }
    }
}

impl Glaze {
    /// Steps of all its runs.
    pub fn steps(&self) -> u64 {
        let steps = self.events.iter().map(|event| match event {
            Event::Run { steps, .. } => u64::from(*steps),
            _ => 0,
        });
        steps.sum()
    }
}

impl Document {
    /// Reads a document; names are looked up in `stock`.
    ///
    /// # Errors
    /// The text is not TOML, a key or name is unknown, or a value not allowed.
    pub fn from_toml(origin: &str, text: &str, stock: &Stock) -> Result<Self, Problem> {
        parse(origin, text, |table| read_document(table, stock))
    }

    /// Reads a document that is JSON, with the same keys.
    ///
    /// # Errors
    /// As [`Document::from_toml`].
    pub fn from_json(origin: &str, text: &str, stock: &Stock) -> Result<Self, Problem> {
        parse_json(origin, text, |table| read_document(table, stock))
    }

    /// Every map that the document names, as often as it does, in its order.
    pub fn map_names_mut(&mut self) -> impl Iterator<Item = &mut MapName> {
        let printed = self.sheet.printed.iter_mut().filter_map(|(_, area)| area.map_name_mut());
        printed.chain(self.glazes.iter_mut().flat_map(|glaze| {
            let outline = glaze.outline.iter_mut();
            let outline = outline.flat_map(|outline| {
                [Some(&mut outline.regions), outline.edges.as_mut(), outline.masked.as_mut()]
            });
            let areas = glaze.events.iter_mut().filter_map(Event::area_mut);
            outline.flatten().chain(areas.filter_map(Area::map_name_mut))
        }))
    }

    /// Every map that the document names, once.
    pub fn map_names(&self) -> BTreeSet<String> {
        self.clone().map_names_mut().map(|name| name.file.clone()).collect()
    }

    /// Steps of all glazes.
    pub fn steps(&self) -> u64 {
        self.glazes.iter().map(Glaze::steps).sum()
    }

    /// The same document with its picture's long edge as long as this, pixels.
    #[must_use]
    pub fn with_long_edge(mut self, pixels: u32) -> Self {
        let [width, height] = self.sheet.size_mm;
        self.sheet.pixels_per_mm = f64::from(pixels) / width.max(height);
        self
    }
}

fn read_document(table: &Table<'_>, stock: &Stock) -> Result<Document, Fault> {
    table.need_format(FORMAT)?;
    let sheet = table.table("sheet", |sheet| read_sheet(sheet, stock))?;
    let sheet = sheet.ok_or_else(|| {
        table.fault("sheet", "the file lacks `[sheet]`").hint("add it with `size = [width, height]` in mm")
    })?;
    let drawing = table.tables("drawing", Figure::read)?.unwrap_or_default();
    if drawing.len() > MAX_FIGURES {
        let message = format!("the drawing has {} figures; {MAX_FIGURES} at most are drawn", drawing.len());
        return Err(table.fault("drawing", message));
    }
    let glazes = table.tables("glaze", |glaze| read_glaze(glaze, stock, drawing.len()))?.unwrap_or_default();
    Ok(Document { title: table.text("title")?.unwrap_or_default(), sheet, drawing, glazes })
}

fn read_sheet(table: &Table<'_>, stock: &Stock) -> Result<SheetSettings, Fault> {
    let size_mm = table.reals::<2>("size", 0.1..=MAX_SIDE_MM)?;
    let size_mm = size_mm.ok_or_else(|| {
        table.fault("size", "`sheet` lacks `size`").hint("add `size = [width, height]` in mm")
    })?;
    let paper = table.text("paper")?.unwrap_or_else(|| "cold-press".to_owned());
    let known = stock.papers.get(&paper);
    let paper = known.map_err(|error| table.fault("paper", error.to_string()).hint(error.hint.clone()))?;
    let printed = table.tables("printed", |print| {
        let area = print.table("area", Area::read)?.unwrap_or_default();
        Ok((read_color(print, "color")?.unwrap_or(LinearRgb::BLACK), area))
    })?;
    let cells_per_mm = table.real("cells_per_mm", Ledger::CELLS_PER_MM)?;
    let trim_mm = table.real("trim", 0.0..=MAX_SIDE_MM)?.unwrap_or(0.0);
    if trim_mm > 0.0 && cells_per_mm.is_none() {
        return Err(table.fault("trim", "`trim` needs `cells_per_mm`").hint("add `cells_per_mm = 4`"));
    }
    if 2.0 * trim_mm >= size_mm[0].min(size_mm[1]) {
        return Err(table.fault("trim", "nothing of the sheet is left").hint("trim less than half of it"));
    }
    Ok(SheetSettings {
        cells_per_mm,
        trim_mm,
        relief_mm: table.real("relief", 0.0..=1.0)?.unwrap_or(0.0),
        size_mm,
        paper: paper.id.clone(),
        seed: table.whole("seed")?.unwrap_or(0),
        ground: read_color(table, "ground")?.unwrap_or(LinearRgb::WHITE),
        printed: printed.unwrap_or_default(),
        pixels_per_mm: table.real("pixels_per_mm", 0.01..=100.0)?.unwrap_or(4.0),
        cells_per_pixel: table.count("cells_per_pixel", 1..=8)?.unwrap_or(1),
    })
}

/// A color, `#rrggbb`, or `{ linear = [r, g, b] }` where that is not exact.
fn read_color(table: &Table<'_>, key: &str) -> Result<Option<LinearRgb>, Fault> {
    if table.is_table(key) {
        let linear = table.table(key, |color| {
            let hint = "give `linear = [r, g, b]`, amounts of light from 0 to 1";
            color
                .reals::<3>("linear", 0.0..=1.0)?
                .ok_or_else(|| color.fault("linear", "a color lacks `linear`").hint(hint))
        })?;
        return Ok(linear.map(LinearRgb));
    }
    let Some(text) = table.text(key)? else { return Ok(None) };
    let color: Result<Srgb, _> = text.parse();
    let wrong = |_| table.fault(key, format!("`{text}` is no color")).hint("write `#rrggbb`");
    Ok(Some(color.map_err(wrong)?.to_linear()))
}

fn read_glaze(table: &Table<'_>, stock: &Stock, drawn: usize) -> Result<Glaze, Fault> {
    let mut pigments = Vec::new();
    for name in table.texts("pigments")?.unwrap_or_default() {
        match stock.pigments.get(&name) {
            Ok(pigment) => pigments.push(pigment.id.clone()),
            Err(error) => return Err(table.fault("pigments", error.to_string()).hint(error.hint())),
        }
    }
    let model: WashModel =
        table.table("wash", |wash| read_model(wash, WashModel::default()))?.unwrap_or_default();
    let events = table.tables("events", |table| {
        let event = read_event(table, pigments.len(), drawn)?;
        let (key, does) = match event {
            Event::Tilt { .. } => ("do", "`tilt`"),
            Event::Run { until_dry: true, .. } => ("until", "`until`"),
            _ => return Ok(event),
        };
        if matches!(model, WashModel::Living(_)) {
            return Ok(event);
        }
        let hint =
            "C97 does not dry by itself nor run down a board; give `model = \"living\"` under `[glaze.wash]`";
        let message = format!("{does} is of the living wash, and the glaze runs by C97");
        Err(table.fault(key, message).hint(hint))
    })?;
    Ok(Glaze {
        name: table.text("name")?.unwrap_or_default(),
        model,
        granulation: table.real("granulation", 0.0..=10.0)?.unwrap_or(1.0),
        outline: table.table("outline", read_outline)?,
        events: events.unwrap_or_default(),
        pigments,
    })
}

fn read_outline(table: &Table<'_>) -> Result<Outline, Fault> {
    let map =
        |key: &str| Ok::<_, Fault>(table.text(key)?.map(|file| MapName { file, place: table.place(key) }));
    let regions = map("regions")?;
    let regions = regions.ok_or_else(|| {
        table
            .fault("regions", "the outline lacks `regions`")
            .hint("name a grey picture, a value for each shape")
    })?;
    Ok(Outline { regions, edges: map("edges")?, masked: map("masked")? })
}

#[derive(Clone, Copy)]
enum Deed {
    Wet,
    Water,
    Pigment,
    Brush,
    Fill,
    Marks,
    Moisten,
    Blot,
    Tilt,
    Run,
    Lift,
    Dry,
}

fn read_event(table: &Table<'_>, pigments: usize, drawn: usize) -> Result<Event, Fault> {
    let deeds = [
        ("wet", Deed::Wet),
        ("water", Deed::Water),
        ("pigment", Deed::Pigment),
        ("brush", Deed::Brush),
        ("fill", Deed::Fill),
        ("marks", Deed::Marks),
        ("moisten", Deed::Moisten),
        ("blot", Deed::Blot),
        ("tilt", Deed::Tilt),
        ("run", Deed::Run),
        ("lift", Deed::Lift),
        ("dry", Deed::Dry),
    ];
    let deed = table.word("do", &deeds)?.ok_or_else(|| {
        let words: Vec<&str> = deeds.iter().map(|(word, _)| *word).collect();
        table.fault("do", "an event lacks `do`").hint(format!("it is one of {}", words.join(", ")))
    })?;
    let area = || Ok(table.table("area", Area::read)?.unwrap_or_default());
    let amounts = || read_amounts(table, "amounts", pigments);
    match deed {
        Deed::Wet => Ok(Event::Wet { area: area()? }),
        Deed::Water => Ok(Event::Water { area: area()?, amount: table.need_real("amount", -100.0..=100.0)? }),
        Deed::Lift => Ok(Event::Lift { area: area()?, fraction: table.need_real("fraction", 0.0..=1.0)? }),
        Deed::Pigment => Ok(Event::Pigment { area: area()?, amounts: amounts()? }),
        Deed::Brush => {
            let water = table.need_real("water", 0.0..=100.0)?;
            Ok(Event::Brush { area: area()?, water, amounts: amounts()? })
        }
        Deed::Fill => Ok(Event::Fill(Fill::read(table, pigments, drawn)?)),
        Deed::Marks => {
            let marks = table.tables("marks", |mark| Mark::read(mark, pigments))?.unwrap_or_default();
            Ok(Event::Marks { marks, rim: table.real("rim", 0.0..=2.0)?.unwrap_or(0.5) })
        }
        Deed::Moisten => {
            Ok(Event::Moisten { area: area()?, volumes: table.need_real("volumes", 0.0..=100.0)? })
        }
        Deed::Blot => Ok(Event::Blot { area: area()?, fraction: table.need_real("fraction", 0.0..=1.0)? }),
        Deed::Tilt => Ok(Event::Tilt {
            degrees: table.need_real("degrees", 0.0..=90.0)?,
            toward: table.real("toward", -360.0..=360.0)?.unwrap_or(90.0),
        }),
        Deed::Run => {
            let steps = table.count("steps", 0..=MAX_STEPS)?;
            let steps = steps.ok_or_else(|| {
                table.fault("steps", "`run` lacks `steps`").hint("add `steps`, a whole number")
            })?;
            let feed = table.table("feed", |feed| {
                Ok(Feed {
                    area: feed.table("area", Area::read)?.unwrap_or_default(),
                    amount: feed.need_real("amount", 0.0..=100.0)?,
                    level: feed.real("level", 0.001..=1000.0)?.unwrap_or(4.0),
                })
            })?;
            let until_dry = table.word("until", &[("dry", true)])?.unwrap_or(false);
            Ok(Event::Run { steps, until_dry, feed })
        }
        Deed::Dry => {
            let (area, damp) = (table.table("area", Area::read)?, table.reals::<2>("damp", -2.0..=2.0)?);
            if area.is_some() && damp.is_some() {
                let message = "`dry` has an `area` and `damp`";
                return Err(table
                    .fault("damp", message)
                    .hint("`damp` is for drying the whole wash; leave one out"));
            }
            Ok(Event::Dry { area, damp: damp.unwrap_or([0.0, 0.0]) })
        }
    }
}

#[cfg(test)]
mod tests;
