//! How much memory work takes, about, told before it begins.
//!
//! Fields are allocated zeroed, and pages that nothing was written to cost nothing: of dry paper only its height is
//! there. So what counts is where water is or pigment was left, in pages.

use std::ops::Range;

use girtin_grid::{Field, Layout};
use girtin_optics::LinearRgb;
use girtin_wash::{WashModel, WashState};

use crate::document::{Document, Event, Glaze};

/// Values that are there if one of them is: a page of floating-point numbers.
const PAGE: usize = 1024;

/// Fields of a wash that have values where it is wet: velocities, pressure, saturation.
const WET_FIELDS: u64 = 4;

/// Fields that the engine keeps beside them, as measured on 4000 × 3000 wet cells.
fn engine_fields(model: &WashModel) -> u64 {
    match model {
        WashModel::C97 { .. } => 1,
        WashModel::Living(_) => 5,
    }
}

/// Bytes of a wash that runs, where it is wet now, without any picture.
pub fn of_wash(state: &WashState, model: &WashModel) -> u64 {
    let layout = state.layout();
    let (mut wet, mut touched, mut height) = (0, 0, 0);
    for y in layout.rows() {
        for page in pages(layout) {
            let here =
                |field: &Field<f32>| field.row(y)[page.clone()].iter().any(|value| value.to_bits() != 0);
            let values = page.len() as u64;
            height += if here(&state.height) { values } else { 0 };
            if state.wet_mask.row(y)[page.clone()].iter().any(|&wet| wet != 0) {
                wet += values;
                continue;
            }
            let fields = [&state.u, &state.v, &state.pressure, &state.saturation];
            let fields = fields.into_iter().chain(&state.suspended).chain(&state.deposited);
            touched += values * fields.filter(|field| here(field)).count() as u64;
        }
    }
    4 * (height + touched) + running(wet, state.suspended.len(), model, layout)
}

fn pages(layout: Layout) -> impl Iterator<Item = Range<usize>> {
    let stride = layout.stride();
    (0..stride).step_by(PAGE).map(move |first| first..(first + PAGE).min(stride))
}

/// Bytes that so many wet cells take while they run, their paper's height apart.
fn running(wet: u64, pigments: usize, model: &WashModel, layout: Layout) -> u64 {
    let own = 1 + 4 * (WET_FIELDS + 2 * pigments as u64);
    // Where the water is a small part of the sheet, it is simulated in a copy, with the height.
    let cells = (layout.width() * layout.height()) as u64;
    let copy = if 2 * wet > cells { 0 } else { own + 4 };
    wet * (own + copy + 4 * engine_fields(model))
}

/// Bytes of a picture in linear light, and of what is written of it.
pub fn of_picture(pixels: u64) -> u64 {
    pixels * (size_of::<LinearRgb>() as u64 + 3)
}

/// Bytes that painting a document takes; `None` if it has more cells than are simulated.
pub fn of_document(document: &Document) -> Option<u64> {
    let size = document.cells().ok()?;
    let layout = Layout::new(size[0], size[1]);
    let cells = (size[0] * size[1]) as u64;
    let [columns, rows] = document.picture_size();
    let pixels = (columns * rows) as u64;
    let cells_per_mm = document.cells_per_mm();
    // The height that all glazes begin with.
    let mut bytes = cells * 4 + of_picture(pixels);
    for glaze in &document.glazes {
        let covered = glaze.events.iter().map(|event| covered(event, size, cells_per_mm));
        bytes += 4 * covered.sum::<u64>();
        // What dried stays until the picture is developed.
        bytes += 4 * cells * (1 + glaze.pigments.len() as u64);
        let wet = wet_cells(glaze, size, cells_per_mm);
        bytes += running(wet, glaze.pigments.len(), &glaze.model, layout);
    }
    Some(bytes)
}

/// Cells around the area of an event.
fn covered(event: &Event, size: [usize; 2], cells_per_mm: f64) -> u64 {
    let area = match event {
        Event::Wet { area }
        | Event::Water { area, .. }
        | Event::Pigment { area, .. }
        | Event::Brush { area, .. }
        | Event::Moisten { area, .. }
        | Event::Blot { area, .. }
        | Event::Lift { area, .. } => Some(area),
        Event::Run { feed, .. } => feed.as_ref().map(|feed| &feed.area),
        Event::Dry { area, .. } => area.as_ref(),
        Event::Fill(_) => return (size[0] * size[1]) as u64,
        Event::Tilt { .. } | Event::Marks { .. } => None,
    };
    area.map_or(0, |area| {
        let [columns, rows] = area.extent(size, cells_per_mm, [0.0; 2]);
        (columns.len() * rows.len()) as u64
    })
}

/// Cells that become wet in a glaze, at most.
pub(crate) fn wet_cells(glaze: &Glaze, size: [usize; 2], cells_per_mm: f64) -> u64 {
    let wets = |event: &&Event| {
        matches!(event, Event::Wet { .. } | Event::Brush { .. } | Event::Fill(_) | Event::Moisten { .. })
    };
    let wet = glaze.events.iter().filter(wets).map(|event| covered(event, size, cells_per_mm));
    wet.sum::<u64>().min((size[0] * size[1]) as u64)
}

/// What painting a document asks the system for, dry fields included, which are never touched.
pub(crate) fn pieces_of_document(document: &Document, [columns, rows]: [usize; 2]) -> Vec<u64> {
    let layout = Layout::new(columns, rows);
    let field = 4 * (layout.stride() * (rows + 3)) as u64;
    let fields: usize = document.glazes.iter().map(|glaze| 6 + 2 * glaze.pigments.len()).sum();
    of_document(document).into_iter().chain(std::iter::repeat_n(field, fields)).collect()
}

#[cfg(test)]
mod tests {
    use girtin_grid::Raster;

    use super::*;
    use crate::Stock;

    #[test]
    fn dry_paper_is_its_height_and_water_all_fields() {
        let height = Raster::new(4056, 1000, 0.5);
        let mut state = WashState::dry(&height, 2);
        let cells = 4056 * 1000;
        let dry = of_wash(&state, &WashModel::c97());
        assert!(dry >= 4 * cells && dry < 5 * cells, "{dry}");
        for y in 0..1000 {
            state.wet_mask.cells_mut(y).fill(1);
        }
        let wet = of_wash(&state, &WashModel::c97());
        assert!(wet > (4 * 9 + 1) * cells && wet < 60 * cells, "{wet}");
        // Pigment that was left where it is dry by now counts once.
        let mut left = WashState::dry(&height, 2);
        (0..1000).for_each(|y| left.deposited[1].cells_mut(y).fill(0.5));
        let left = of_wash(&left, &WashModel::c97());
        assert!((8 * cells..9 * cells).contains(&left), "{left}");
        assert!(of_wash(&state, &WashModel::living()) > wet);
    }

    #[test]
    fn a_document_takes_what_its_glazes_wet() {
        let paint = |radius: f64| {
            let text = format!(
                "format = 1\n[sheet]\nsize = [100, 100]\n[[glaze]]\npigments = ['PB60']\n[[glaze.events]]\n\
                 do = 'wet'\narea = {{ shape = 'disc', center = [50, 50], radius = {radius} }}\n"
            );
            of_document(&Document::from_toml("d.toml", &text, &Stock::builtin()).unwrap()).unwrap()
        };
        let cells = 400 * 400;
        let bare = 3 * 4 * cells + 27 * cells;
        assert!(paint(1.0) > bare && paint(1.0) < bare + bare / 100);
        // Twice the width is four times the cells.
        assert_eq!(paint(20.0) - bare, 4 * (paint(10.0) - bare));
    }
}
