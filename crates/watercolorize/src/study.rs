//! The photograph as a painter looks at it before the first wash.

use girtin_grid::Raster;
use girtin_grid::blur::{gaussian, gaussian_plane};
use girtin_grid::resize::resized_plane;

use crate::abstraction::abstracted;
use crate::accidents::{noise, plane, smoothstep};
use crate::attention::{attention, quantile};
use crate::lines::{ink, light_lines, warped};
use crate::mount::Mount;
use crate::painter::Request;
use crate::regions::{self, Finding, cleaned, regions, voted};
use crate::settings::PhotoParams;

/// Part of a step that is made within two cells, for an edge that counts as blurred and one that counts as sharp.
const SHARP: [f32; 2] = [0.45, 0.9];

/// Cells over which an edge of the photograph makes its step.
const STEP: f64 = 3.0;

/// How much of what `detail` is above 1 is added to the exactness of every cell.
const EVERYWHERE: f32 = 0.9;

/// Steps over a few cells, Lab, up to which and from which on there is an edge that could be sharp.
const EDGE: [f32; 2] = [3.0, 9.0];

/// How much what steps less than an edge counts as soft where nothing is drawn exactly.
const MODELLED: f32 = 0.2;

/// Rasters of the sheet's cells.
pub type Plane = Raster<f32>;
/// Lab or linear colors of the sheet's cells.
pub type Colors = Raster<[f32; 3]>;

/// What is known of the photograph, a value for each cell of the sheet.
#[derive(Debug)]
pub struct Study<'a> {
    /// How it is painted.
    pub params: &'a PhotoParams,
    /// Seed of all accidents.
    pub seed: u64,
    /// Where it lies on the sheet.
    pub mount: Mount,
    /// The photograph in Lab.
    pub photo: Colors,
    /// The same abstracted, broadest first.
    pub abstractions: Vec<Colors>,
    /// How exactly each cell is drawn, with the parameter in it; 0 to 1.
    pub exact: Plane,
    /// How sharp the photograph's edges are around each cell, 0 for blurred ones to 1.
    pub sharp: Plane,
    /// How much the photograph itself changes at each cell, Lab.
    pub steps: Plane,
    /// How rough the photograph is, 0 to 1.
    pub rough: Plane,
    /// How far inside the painting's border each cell is, cells.
    pub inside: Plane,
    /// Distance from the photograph's border, negative inside, cells.
    pub distance: Plane,
    /// What stays bare: 1.
    pub bare: Raster<u8>,
    /// Masking fluid on thin light lines, twice as fine as the sheet's cells.
    pub masked: Option<Plane>,
}

impl<'a> Study<'a> {
    /// Looks at the photograph on its sheet; `paper` is the sheet's height.
    pub fn new(request: &Request<'a>, mount: Mount, paper: &Plane) -> Self {
        let params = request.params;
        let photo = mount.place_lab(request.photo);
        let exact = match request.detail_map {
            Some(map) => mount.place(&map.map(|value| [value])).map(|[value]| value),
            None => attention(&photo, &mount),
        };
        // Who asks for more detail than there is where the eye rests wants some of it everywhere.
        let (detail, everywhere) = (params.detail as f32, EVERYWHERE * (params.detail as f32 - 1.0).max(0.0));
        let exact = exact.map(|exact| (exact * detail + everywhere).clamp(0.0, 1.0));
        let simpler = mount.cells(params.simplification);
        let radius = exact.map(|exact| {
            let exact = f64::from(exact);
            (simpler * (0.013 * (1.0 - exact) + 0.0022 * exact)) as f32
        });
        let times = |by: f32| radius.map(|radius| radius * by);
        let broad = abstracted(&photo, &radius);
        let rough = roughness(&photo, &broad, &exact, &mount);
        let masked = (params.detail > 0.0).then(|| {
            // Thin lines would be beads on the sheet's own cells.
            let mount = mount.finer();
            let exact = resized_plane(&exact, mount.size[0], mount.size[1]);
            light_lines(&mount.place_lab(request.photo), &mount, &exact)
        });
        let sharp = sharpness(&photo, &exact, &mount);
        let inside = mount.painted(&request.mounting, params.vignette as f32, paper, request.seed);
        let mut study = Self {
            params,
            seed: request.seed,
            abstractions: vec![
                abstracted(&broad, &times(2.0)),
                broad,
                abstracted(&photo, &times(0.5)),
                abstracted(&photo, &times(0.28)),
            ],
            distance: mount.distance(),
            bare: Raster::new(mount.size[0], mount.size[1], 0),
            steps: most_within(&regions::steps(&photo, STEP), 1),
            exact,
            sharp,
            photo,
            rough,
            inside,
            masked,
            mount,
        };
        study.bare = study.reserves(request.reserve);
        study
    }

    /// How far what changes around a cell does so softly, and is painted without steps; 0 to 1.
    pub fn graded(&self, x: usize, y: usize) -> f32 {
        1.0 - self.sharp.at(x, y)
    }

    /// Cells of a part of the long edge.
    pub fn cells(&self, part: f64) -> f64 {
        self.mount.cells(part)
    }

    /// Cells of a part of the long edge's square.
    pub fn area(&self, part: f64) -> f64 {
        part * self.cells(1.0) * self.cells(1.0)
    }

    /// The lightness that a part of the photograph is darker than.
    pub fn lightness(&self, part: f64) -> f32 {
        let cells = self.abstractions[1].as_slice().iter().zip(self.distance.as_slice());
        quantile(cells.filter(|(_, distance)| **distance < 0.0).map(|(lab, _)| lab[0]), part)
    }

    /// White that stays paper: only where most of its edge is hard, so that pale skies fade to paper instead of ending in a
    /// curve; slivers between shapes; and what the caller reserves.
    fn reserves(&self, reserve: Option<&Plane>) -> Raster<u8> {
        let [width, height] = self.mount.size;
        let broad = &self.abstractions[1];
        let finest = &self.abstractions[3];
        let is_white = |[l, a, b]: [f32; 3], least: f32| l > least && libm::hypotf(a, b) < 7.0;
        // Fine lights are white by themselves where all is exact; elsewhere only in what is white at large. What is written
        // on white is never white.
        let white = Raster::by_rows(width, height, |x, y| {
            let at_large = is_white(broad.at(x, y), 94.0) || self.exact.at(x, y) > 0.3;
            f32::from(u8::from(at_large && is_white(finest.at(x, y), 92.5)))
        });
        let sharp = white.map(|white| u8::from(white > 0.5));
        let round = gaussian_plane(&white, self.cells(0.003)).map(|white| u8::from(white > 0.5));
        let white = Raster::by_rows(width, height, |x, y| {
            if self.exact.at(x, y) > 0.3 { sharp.at(x, y) } else { round.at(x, y) & sharp.at(x, y) }
        });
        let least = self.exact.map(|exact| self.area(1.5e-4) as f32 * (1.05 - exact));
        let mut bare = cleaned(&white, &least, 0.0);
        let steps = regions::steps(broad, self.cells(0.008));
        let pieces = regions::connected(&bare);
        let count = pieces.as_slice().iter().max().map_or(0, |most| *most as usize + 1);
        let mut rims = vec![[0u32; 2]; count];
        for y in 1..height.saturating_sub(1) {
            for x in 1..width.saturating_sub(1) {
                let around = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
                if bare.at(x, y) != 0
                    && self.distance.at(x, y) < 0.0
                    && around.iter().any(|&(x, y)| bare.at(x, y) == 0)
                {
                    let rim = &mut rims[pieces.at(x, y) as usize];
                    rim[0] += 1;
                    rim[1] += u32::from(steps.at(x, y) < 16.0);
                }
            }
        }
        for (cell, &piece) in bare.as_mut_slice().iter_mut().zip(pieces.as_slice()) {
            let [all, soft] = rims[piece as usize];
            *cell &= u8::from(f64::from(soft) <= 0.35 * f64::from(all.max(1)));
        }
        let slivers = self.slivers(&steps);
        bare.as_mut_slice().iter_mut().zip(slivers.as_slice()).for_each(|(bare, sliver)| *bare |= sliver);
        if let Some(reserve) = reserve {
            let reserve = self.mount.place(&reserve.map(|value| [value]));
            let cells = bare.as_mut_slice().iter_mut().zip(reserve.as_slice());
            cells.for_each(|(bare, [reserve])| *bare |= u8::from(*reserve >= 0.5));
        }
        bare
    }

    /// Slivers of paper left between shapes, few, where edges are hard and light and nothing is exact.
    fn slivers(&self, steps: &Plane) -> Raster<u8> {
        let [width, height] = self.mount.size;
        let much = self.params.slivers as f32;
        if much <= 0.0 {
            return Raster::new(width, height, 0);
        }
        let finding = Finding {
            scale: 196.0,
            least_cells: self.area(8e-4) as usize,
            rounding: self.cells(0.004),
            least_step: 26.0,
        };
        let (_, edges) = voted(&regions(&self.abstractions[1], steps, &finding), self.cells(0.002));
        let chance = plane(self.seed, "slivers", self.mount.size, self.cells(0.03));
        let light = gaussian(&self.abstractions[1], self.cells(0.004));
        let loose = gaussian_plane(&self.exact, self.cells(0.01));
        let reach = self.cells(0.0022) as f32 * much;
        let there = Raster::by_rows(width, height, |x, y| {
            let chance = (chance.at(x, y) - 0.9).clamp(0.0, 1.2);
            let loose = smoothstep(-loose.at(x, y), -0.4, -0.08);
            let is_light = light.at(x, y)[0] > 45.0 && self.distance.at(x, y) < -self.cells(0.02) as f32;
            u8::from(is_light && edges.at(x, y) < reach * chance * loose * self.sharp.at(x, y))
        });
        // What is a cell wide would be a row of dots.
        let round = gaussian_plane(&there.map(f32::from), 1.0);
        let there = Raster::by_rows(width, height, |x, y| u8::from(round.at(x, y) > 0.5) & there.at(x, y));
        let area = self.area(6e-5) as f32;
        cleaned(&there, &Raster::new(width, height, area), 0.0)
    }

    /// How hard the photograph's edges are around each cell, 0 to 1.
    pub fn hardness(&self, steps: &Plane) -> Plane {
        let threshold = self.params.edge_threshold as f32;
        let mut hard =
            gaussian_plane(steps, 1.0).map(|step| smoothstep(step, 8.0 * threshold, 26.0 * threshold));
        let cells = hard.as_mut_slice().iter_mut().zip(self.sharp.as_slice());
        cells.for_each(|(hard, sharp)| *hard *= sharp);
        // Spread, so that both sides of an edge know it.
        let wide = gaussian_plane(&hard, self.cells(0.004));
        wide.map(|hard| (2.6 * hard).min(1.0))
    }

    /// The ink drawing of the photograph, twice as fine as the sheet's cells, as lines are thin; by a hand that wavers and
    /// presses unevenly.
    pub fn ink(&self, photo: &Colors) -> Plane {
        let mount = self.mount.finer();
        let [width, height] = mount.size;
        let exact = resized_plane(&self.exact, width, height);
        let inside = resized_plane(&self.inside, width, height);
        let lines = ink(&mount.place_lab(photo), &mount, &exact, self.params.ink as f32);
        let amplitude = mount.cells(0.0012) as f32;
        let stray = noise::<2>(self.seed, "ink wobble", mount.size, mount.cells(0.02));
        let lines = warped(&lines.map(|line| [line]), &stray.map(|by| by.map(|by| by * amplitude)));
        let pressure = plane(self.seed, "ink pressure", mount.size, mount.cells(0.02));
        Raster::by_rows(width, height, |x, y| {
            let pressure = (0.85 + 0.3 * pressure.at(x, y)).clamp(0.25, 1.0);
            let there = f32::from(u8::from(inside.at(x, y) > self.mount.cells(0.002) as f32));
            (lines.at(x, y)[0] * pressure * there * 0.92).clamp(0.0, 1.0)
        })
    }
}

/// How sharp the edges of a Lab photograph are: how much of what it changes over a few cells it changes over two.
fn sharpness(photo: &Colors, exact: &Plane, mount: &Mount) -> Plane {
    let [near, far] = [2.0, mount.cells(0.011)].map(|distance| {
        // Off an edge it is still that edge which is judged.
        most_within(&regions::steps(photo, distance), mount.cells(0.006) as usize)
    });
    let sharp = Raster::by_rows(photo.width(), photo.height(), |x, y| {
        let (near, far) = (near.at(x, y), far.at(x, y));
        // Of flat modelling a painter makes steps, but for what is drawn exactly.
        let modelled = 1.0 - smoothstep(far, EDGE[0], EDGE[1]);
        let modelled = modelled * (MODELLED + (1.0 - MODELLED) * exact.at(x, y));
        smoothstep(near / far.max(1.0), SHARP[0], SHARP[1]) * (1.0 - modelled)
    });
    gaussian_plane(&sharp, mount.cells(0.004))
}

/// The most of each cell and those up to `radius` from it, by squares.
fn most_within(plane: &Plane, radius: usize) -> Plane {
    let (width, height) = (plane.width(), plane.height());
    let most = |values: &mut dyn Iterator<Item = f32>| values.fold(f32::NEG_INFINITY, f32::max);
    let along = Raster::by_rows(width, height, |x, y| {
        most(&mut plane.row(y)[x.saturating_sub(radius)..(x + radius + 1).min(width)].iter().copied())
    });
    Raster::by_rows(width, height, |x, y| {
        most(&mut (y.saturating_sub(radius)..(y + radius + 1).min(height)).map(|y| along.at(x, y)))
    })
}

/// Where the photograph is rough, and nothing exact: rock, foliage, rippled water. 0 to 1.
fn roughness(fine: &Colors, broad: &Colors, exact: &Plane, mount: &Mount) -> Plane {
    let texture = Raster::by_rows(fine.width(), fine.height(), |x, y| {
        let off = fine.at(x, y)[0] - broad.at(x, y)[0];
        off * off
    });
    let texture = gaussian_plane(&texture, mount.cells(0.012));
    Raster::by_rows(fine.width(), fine.height(), |x, y| {
        let rough = smoothstep(texture.at(x, y).max(0.0).sqrt(), 2.0, 7.0);
        rough * (1.0 - 0.9 * exact.at(x, y))
    })
}
