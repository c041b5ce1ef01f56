//! All that is seen of a photograph before anything is decided.

use girtin_grid::Raster;
use girtin_grid::blur::gaussian_plane;
use girtin_grid::resize::resized_plane;

use crate::attention::{Area, attention, snapped};
use crate::crisp::crisp;
use crate::faces::{faces, in_figures, in_heads};
use crate::masses::steps;
use crate::mount::Mount;
use crate::painter::Request;
use crate::simplify::{flattened, simplified};
use crate::texture::{Texture, busy, texture};
use crate::values::Values;

/// A value a cell.
pub type Plane = Raster<f32>;
/// A color a cell.
pub type Colors = Raster<[f32; 3]>;

/// Over how much of the long edge attention is spread for values: with attention itself a dark ring stood round every
/// subject.
const WIDE: f64 = 0.09;
/// How busy something is that keeps its seams, 0 to 1.
const FINE: f32 = 0.75;
/// What the rest is looked at where there are faces.
const BESIDE_FACES: f32 = 0.75;

/// A photograph as a painter has looked at it.
#[derive(Debug)]
pub struct Study {
    /// How it lies on its sheet.
    pub mount: Mount,
    /// The photograph, Lab.
    pub lab: Colors,
    /// The same with fewer details where nobody looks, Lab.
    pub simple: Colors,
    /// How exactly each cell is drawn, 0 to 1.
    pub attention: Plane,
    /// The same for values, wider.
    pub near_focus: Plane,
    /// How much of a cell is a face, 0 to 1.
    pub face: Plane,
    /// Where it is busy, and which way.
    pub texture: Texture,
    /// How much the photograph changes.
    pub steps: Plane,
    /// Its values.
    pub values: Values,
    /// The planned lightness, and the photograph's own hue: L, a, b.
    pub planned: Colors,
}

impl Study {
    /// Looks at a photograph.
    pub fn new(request: &Request<'_>, mount: Mount) -> Self {
        let s = mount.long_edge;
        let photo = mount.place_lab(request.photo);
        let area = Area { origin: [mount.origin; 2], size: mount.photo };
        let whole = |plane: &Plane| mount.place(&plane.map(|value| [value])).map(|[value]| value);
        let lightness = Raster::by_rows(area.size[0], area.size[1], |x, y| {
            photo.at(area.origin[0] + x, area.origin[1] + y)[0]
        });
        let found = faces(&lightness);
        let heads = whole(&in_heads(&found, area.size));
        // Features of a face, and what is finely made, are no wider than seams.
        let (crisp, fine) = (crisp(&photo, s), busy(&photo.map(|[l, ..]| l), s));
        let lab = Raster::by_rows(photo.width(), photo.height(), |x, y| {
            let is_kept = heads.at(x, y) > 0.02 || fine.at(x, y) > FINE;
            if is_kept { photo.at(x, y) } else { crisp.at(x, y) }
        });
        let figures = whole(&in_figures(&found, area.size));
        let detail = request.params.detail as f32;
        let texture = texture(&lab, s);
        let flat = flattened(&lab, s);
        let attention = match request.detail_map {
            Some(map) => whole(&resized_plane(map, area.size[0], area.size[1])),
            None => {
                let seen = attention(&lab, area, &figures, s);
                let seen = if found.is_empty() { seen } else { seen.map(|seen| BESIDE_FACES * seen) };
                let seen =
                    Raster::by_rows(lab.width(), lab.height(), |x, y| seen.at(x, y).max(figures.at(x, y)));
                let seen = focused(seen, request.focus, &mount);
                let mut seen = snapped(&seen, &flat, s);
                seen.as_mut_slice().iter_mut().zip(heads.as_slice()).for_each(|(seen, &head)| {
                    *seen = (*seen * detail).min(1.0).max(head);
                });
                seen
            }
        };
        let simple = simplified(&lab, &flat, &attention, &texture.foliage, s);
        let near_focus = gaussian_plane(&attention, WIDE * s);
        let near_focus =
            Raster::by_rows(lab.width(), lab.height(), |x, y| near_focus.at(x, y).max(heads.at(x, y)));
        let inside = (0..area.size[1]).flat_map(|y| {
            simple.row(area.origin[1] + y)[area.origin[0]..][..area.size[0]].iter().map(|color| color[0])
        });
        let values = Values::new(request.params, inside);
        let planned = Raster::by_rows(lab.width(), lab.height(), |x, y| {
            let [l, a, b] = simple.at(x, y);
            [values.of(l, near_focus.at(x, y)), a, b]
        });
        let steps = steps(&lab, s);
        Self { mount, lab, simple, attention, near_focus, face: heads, texture, steps, values, planned }
    }

    /// A part of the long edge, cells.
    pub fn cells(&self, part: f64) -> f64 {
        self.mount.cells(part)
    }

    /// The mean of a plane along a path, cells.
    pub fn along(&self, path: &[[f32; 2]], plane: &Plane) -> f32 {
        path.iter().map(|&[x, y]| plane.sample(x, y)).sum::<f32>() / path.len().max(1) as f32
    }

    /// A place in cells in millimetres, to a hundredth.
    pub fn mm(&self, [x, y]: [f32; 2]) -> [f64; 2] {
        [x, y].map(|at| hundredths(f64::from(at) / self.mount.cells_per_mm))
    }
}

/// To a hundredth.
pub fn hundredths(value: f64) -> f64 {
    libm::round(value * 100.0) / 100.0
}

/// Attention drawn to a point, parts of the photograph's width and height.
fn focused(seen: Plane, focus: Option<[f64; 2]>, mount: &Mount) -> Plane {
    let Some(focus) = focus else { return seen };
    let at = [0, 1].map(|axis: usize| (mount.origin as f64 + focus[axis] * mount.photo[axis] as f64) as f32);
    let wide = mount.cells(0.16) as f32;
    Raster::by_rows(seen.width(), seen.height(), |x, y| {
        let away = libm::hypotf(x as f32 - at[0], y as f32 - at[1]) / wide;
        let near = libm::expf(-0.5 * away * away);
        (0.45 * seen.at(x, y) + near * (0.55 + 0.45 * seen.at(x, y))).min(1.0)
    })
}
