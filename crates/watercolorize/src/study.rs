//! The photograph as a painter looks at it before the first wash.

use girtin_grid::Raster;
use girtin_grid::blur::{gaussian, gaussian_plane};
use girtin_grid::morphology::{dilated, eroded};
use girtin_grid::resize::resized_plane;

use crate::abstraction::abstracted;
use crate::accidents::{noise, plane, smoothstep};
use crate::attention::attention;
use crate::faces::{faces, in_figures};
use crate::lines::{ink, lights, warped};
use crate::mount::{Mount, Mounting};
use crate::painter::Request;
use crate::regions;
use crate::settings::PhotoParams;
use crate::tone::Tones;

/// Part of a step that is made within two cells, for an edge that counts as blurred and one that counts as sharp.
const SHARP: [f32; 2] = [0.45, 0.9];

/// Cells over which an edge of the photograph makes its step.
const STEP: f64 = 3.0;

/// Wetness beyond which no masking fluid is taken.
const WETTEST_WITH_FLUID: f64 = 2.0;

/// How much of what `detail` is above 1 is added to the exactness of every cell.
const EVERYWHERE: f32 = 0.9;

/// Up to which part of the long edge what changes is texture, and how much smaller the shapes of the roughest are.
const TEXTURE: f64 = 0.006;
const FINER: f32 = 0.5;

/// How much of their sharpness the edges of rough parts lose where shapes run together, and the noise below 0 there: not
/// every leaf has an outline.
const LOST: f32 = 0.95;
const LOST_AT: [f32; 2] = [-0.7, 0.3];

/// Steps over a few cells, Lab, up to which and from which on there is an edge that could be sharp.
const EDGE: [f32; 2] = [3.0, 9.0];

/// How much what steps less than an edge counts as soft where nothing is drawn exactly.
const MODELLED: f32 = 0.2;

/// A tier of tones, a part of the photograph's range of lightness, and how far its border strays, parts of a tier.
pub const TIER: f32 = 0.27;
const STRAY: f32 = 0.35;

/// Between which parts of the long edge what is soft is a form, and how far tones must differ between them, Lab, up to which
/// and from which on.
const FORM: [f64; 2] = [0.012, 0.05];
const DIFFERING: [f32; 2] = [1.0, 3.0];

/// Over how much of the long edge slopes of tone are compared, and how much of them goes one way in what is a form and in
/// what only fades.
const ONE_WAY_OVER: f64 = 0.06;
const ONE_WAY: [f32; 2] = [0.7, 0.92];

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
    /// How it ends there.
    pub mounting: Mounting,
    /// The photograph in Lab.
    pub photo: Colors,
    /// The tones it is painted in.
    pub tones: Tones,
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
    /// Where soft tones make forms and do not only fade, 0 to 1.
    pub forms: Plane,
    /// How far the borders stray where tones step, Lab.
    pub stray_tone: Plane,
    /// Unevenness of hue, of variance 1.
    pub drift: Raster<[f32; 2]>,
    /// Where water pools, of variance 1.
    pub pools: Plane,
    /// Where edges that the photograph has lost are found again, and those of rough parts are not lost: the higher, the more; of
    /// variance 1.
    pub found: Plane,
    /// How far inside the painting's border each cell is, cells.
    pub inside: Plane,
    /// Distance from the photograph's border, negative inside, cells.
    pub distance: Plane,
    /// What stays bare: 1.
    pub bare: Raster<u8>,
    /// Masking fluid on lines and points of light, twice as fine as the sheet's cells.
    pub masked: Option<Plane>,
}

impl<'a> Study<'a> {
    /// Looks at the photograph on its sheet; `paper` is the sheet's height.
    pub fn new(request: &Request<'a>, mount: Mount, paper: &Plane) -> Self {
        let params = request.params;
        let photo = mount.place_lab(request.photo);
        // Thin lines would be beads on the sheet's own cells, and small faces are not seen there.
        let finer = mount.finer();
        let fine = finer.place_lab(request.photo);
        let (exact, faces) = match request.detail_map {
            Some(map) => (mount.place(&map.map(|value| [value])).map(|[value]| value), Vec::new()),
            None => rayon::join(|| attention(&photo, &mount), || faces(&fine.map(|[l, ..]| l))),
        };
        // Who asks for more detail than there is where the eye rests wants some of it everywhere.
        let (detail, everywhere) = (params.detail as f32, EVERYWHERE * (params.detail as f32 - 1.0).max(0.0));
        let mut exact = exact.map(|exact| (exact * detail + everywhere).clamp(0.0, 1.0));
        if !faces.is_empty() {
            // A loose hand keeps a likeness all the same.
            let much = detail.sqrt().min(1.0);
            let inside = in_figures(&faces, mount.size);
            let cells = exact.as_mut_slice().iter_mut().zip(inside.as_slice());
            cells.for_each(|(exact, inside)| *exact = exact.max(much * inside));
        }
        let simpler = mount.cells(params.simplification);
        let texture = roughness(&photo, &gaussian(&photo, mount.cells(TEXTURE)), &exact, &mount);
        let radius = Raster::by_rows(exact.width(), exact.height(), |x, y| {
            let exact = f64::from(exact.at(x, y));
            // Broad shapes of gravel and foliage are camouflage; small ones are stones and leaves.
            let finer = f64::from(1.0 - FINER * texture.at(x, y));
            (simpler * (0.013 * (1.0 - exact) + 0.0022 * exact) * finer) as f32
        });
        let times = |by: f32| radius.map(|radius| radius * by);
        // Lines as fine as a hair over what all runs would be scratches.
        let masked = (params.detail > 0.0 && params.wetness <= WETTEST_WITH_FLUID).then(|| {
            let exact = resized_plane(&exact, finer.size[0], finer.size[1]);
            lights(&fine, &finer, &exact)
        });
        let covered = masked.as_ref().map(|masked| without_lights(&photo, masked, &mount));
        let covered = covered.as_ref().unwrap_or(&photo);
        let broad = abstracted(covered, &radius);
        let rough = roughness(covered, &broad, &exact, &mount);
        let found = plane(request.seed, "found edges", mount.size, mount.cells(0.05));
        let mut sharp = sharpness(&photo, &exact, &mount);
        let cells = sharp.as_mut_slice().iter_mut().zip(rough.as_slice()).zip(found.as_slice());
        cells.for_each(|((sharp, rough), found)| {
            *sharp *= 1.0 - LOST * rough * smoothstep(-found, LOST_AT[0], LOST_AT[1])
        });
        let inside = mount.painted(&request.mounting, params.vignette as f32, paper, request.seed);
        let distance = mount.distance();
        let cells = photo.as_slice().iter().zip(distance.as_slice());
        let lightness = cells.filter(|(_, distance)| **distance < 0.0).map(|(lab, _)| lab[0]);
        let tones = Tones::new(params, lightness);
        let mut study = Self {
            params,
            seed: request.seed,
            mounting: request.mounting,
            abstractions: vec![
                abstracted(&broad, &times(2.0)),
                broad,
                abstracted(covered, &times(0.5)),
                abstracted(covered, &times(0.28)),
            ],
            distance,
            bare: Raster::new(mount.size[0], mount.size[1], 0),
            steps: dilated(&regions::steps(&photo, STEP), 1),
            exact,
            sharp,
            tones,
            stray_tone: stray_tone(request.seed, &photo, STRAY * TIER * tones.range, &mount),
            forms: forms(&photo, &mount),
            drift: noise(request.seed, "charging", mount.size, mount.cells(0.05)),
            pools: plane(request.seed, "pools", mount.size, mount.cells(0.045)),
            found,
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
        // What is drawn exactly steps where the photograph does, and its modelling not at all: skin has no contours.
        let modelled = self.exact.at(x, y) * (1.0 - smoothstep(self.steps.at(x, y), EDGE[0], EDGE[1]));
        1.0 - self.sharp.at(x, y) * (1.0 - modelled)
    }

    /// Cells of a part of the long edge.
    pub fn cells(&self, part: f64) -> f64 {
        self.mount.cells(part)
    }

    /// Cells of a part of the long edge's square.
    pub fn area(&self, part: f64) -> f64 {
        part * self.cells(1.0) * self.cells(1.0)
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
        dilated(&regions::steps(photo, distance), mount.cells(0.006) as usize)
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

/// Where soft tones make forms, as out of focus, and do not only fade, as in a clear sky; 0 to 1.
fn forms(photo: &Colors, mount: &Mount) -> Plane {
    // Beyond the border a fade fades on: mirrored it would be a form there.
    let around = (3.0 * mount.cells(FORM[1])) as usize;
    let [columns, rows] = mount.photo;
    let light = Raster::by_rows(columns + 2 * around, rows + 2 * around, |x, y| {
        let ([x, back_x], [y, back_y]) = (beyond(x, around, columns), beyond(y, around, rows));
        let of_photo = |x: usize, y: usize| photo.at(mount.origin + x, mount.origin + y)[0];
        2.0 * of_photo(x, y) - of_photo(back_x, back_y)
    });
    let [near, far] = FORM.map(|over| gaussian_plane(&light, mount.cells(over)));
    // Along one direction alone tones only fade, however fast.
    let slopes = Raster::by_rows(light.width(), light.height(), |x, y| {
        let across = near.at((x + 1).min(light.width() - 1), y) - near.at(x.saturating_sub(1), y);
        let down = near.at(x, (y + 1).min(light.height() - 1)) - near.at(x, y.saturating_sub(1));
        [across * across, down * down, across * down]
    });
    let slopes = gaussian(&slopes, mount.cells(ONE_WAY_OVER));
    let off = Raster::by_rows(photo.width(), photo.height(), |x, y| {
        let [x, y] = [(x, columns), (y, rows)].map(|(at, of)| beyond(at, mount.origin, of)[0] + around);
        let [across, down, both] = slopes.at(x, y);
        let one_way = libm::hypotf(across - down, 2.0 * both) / (across + down).max(1e-9);
        let many_ways = 1.0 - smoothstep(one_way, ONE_WAY[0], ONE_WAY[1]);
        (near.at(x, y) - far.at(x, y)).abs() * many_ways
    });
    gaussian_plane(&off, mount.cells(FORM[1])).map(|off| smoothstep(off, DIFFERING[0], DIFFERING[1]))
}

/// The cell of a row of `of` that is nearest to one which lies `around` before it or more, and as far inside as that is beyond.
fn beyond(at: usize, around: usize, of: usize) -> [usize; 2] {
    let (at, last) = (at as isize - around as isize, of as isize - 1);
    let nearest = at.clamp(0, last);
    [nearest, (2 * nearest - at).clamp(0, last)].map(|at| at as usize)
}

/// How far the borders of tiers of tones stray, Lab, `most` in the mean: no farther than tones differ around there, or an
/// even sky would get islands that nothing in it explains.
fn stray_tone(seed: u64, photo: &Colors, most: f32, mount: &Mount) -> Plane {
    let uneven = plane(seed, "tiers", mount.size, mount.cells(0.032));
    let moments = gaussian(&photo.map(|[l, ..]| [l, l * l]), mount.cells(0.018));
    let differing = moments.map(|[mean, square]| (square - mean * mean).max(0.0).sqrt());
    // What is even is so up to its edge.
    let differing = eroded(&differing, mount.cells(0.025) as usize);
    Raster::by_rows(photo.width(), photo.height(), |x, y| uneven.at(x, y) * most.min(differing.at(x, y)))
}

/// The photograph as it would be without the lights that masking fluid covers: washes go over them.
fn without_lights(photo: &Colors, masked: &Plane, mount: &Mount) -> Colors {
    let [width, height] = mount.size;
    let covered = resized_plane(masked, width, height).map(|masked| smoothstep(masked, 0.04, 0.25));
    let covered = dilated(&covered, 1);
    let beside = Raster::by_rows(width, height, |x, y| {
        let seen = 1.001 - covered.at(x, y);
        let [l, a, b] = photo.at(x, y);
        [seen * l, seen * a, seen * b, seen]
    });
    let beside = gaussian(&beside, mount.cells(0.004));
    Raster::by_rows(width, height, |x, y| {
        let (own, [l, a, b, seen]) = (photo.at(x, y), beside.at(x, y));
        let without = [l, a, b].map(|sum| sum / seen);
        [0, 1, 2].map(|c: usize| own[c] + covered.at(x, y) * (without[c] - own[c]))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fade_is_no_form_up_to_the_border_and_blurred_discs_are() {
        let mounting = Mounting { margin: 0.0, ..Mounting::default() };
        let mount = Mount::new([320, 240], 320.0, &mounting);
        let [width, height] = mount.size;
        let most = |light: &dyn Fn(f32, f32) -> f32| {
            let forms =
                forms(&Raster::from_fn(width, height, |x, y| [light(x as f32, y as f32), 0.0, 0.0]), &mount);
            forms.as_slice().iter().fold(0.0f32, |most, &form| most.max(form))
        };
        // To the right, and ever faster downward.
        assert!(most(&|x, _| 10.0 + 0.25 * x) < 0.02);
        assert!(most(&|_, y| 90.0 - 0.001 * y * y) < 0.02);
        let disc = |x: f32, y: f32| 40.0 * libm::expf(-(x * x + y * y) / 400.0);
        assert!(most(&|x, y| 40.0 + disc(x - 160.0, y - 120.0) + disc(x - 100.0, y - 90.0)) > 0.9);
    }
}
