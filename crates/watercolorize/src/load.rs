//! A wash is planned: what is missing on the sheet as it dried, and how much water and pigment are laid for it.

use girtin_grid::Raster;
use girtin_grid::blur::{gaussian, gaussian_plane, within};
use girtin_grid::morphology::dilated;
use girtin_grid::resize::{resized, resized_plane};
use girtin_optics::LinearRgb;

use crate::accidents::{plane, smoothstep};
use crate::intent::{Intent, lacking, mixed};
use crate::lines::warped;
use crate::regions::{Regions, cleaned, colored, voted_as_seen};
use crate::separate::{Limits, MOST, Paints, in_lab, separated};
use crate::study::{Colors, Plane, Study};
use crate::washes::WashPlan;

/// Film that dry pores drink, on average: the living wash's pore depth times its mean capacity.
const DRUNK: f32 = 0.18;

/// How far, Lab, what is missing must be above the least that is laid for a mark to count as clear.
const FAINT: f32 = 5.0;

/// Steps of the photograph over a few cells, Lab, up to which and from which on a hole in a shape is modelling or a thing.
const HOLE: [f32; 2] = [12.0, 28.0];

/// How near the painting's border the brush runs dry, a part of the long edge, and how much less water there is then.
const DRY_WITHIN: f64 = 0.014;
const DRY: f32 = 0.95;
/// Noise of variance 1 up to which and from which on it does.
const RUN_DRY: [f32; 2] = [-1.2, 0.2];

/// Noise of variance 1 from which on and above which edges that the photograph has lost are found again.
const FOUND: [f32; 2] = [-0.6, 0.3];

/// A wash ready to be laid.
pub struct Load {
    /// Which shape each cell belongs to, 0 for none, and how far inside it its middle is.
    pub shapes: Raster<u8>,
    pub edges: Plane,
    /// Amounts of each pigment.
    pub amounts: Raster<[f32; MOST]>,
    /// Film.
    pub water: Plane,
    /// Pore water before the brush comes, volumes.
    pub moist: Plane,
}

/// The sheet that a wash is planned on.
#[derive(Clone, Copy, Debug)]
pub struct Planner<'a> {
    /// The photograph.
    pub study: &'a Study<'a>,
    /// Height of the paper.
    pub paper: &'a Plane,
    /// The sheet as it is now.
    pub current: &'a Raster<LinearRgb>,
    /// The palette.
    pub paints: &'a Paints,
}

impl Planner<'_> {
    /// Plans a wash on the sheet as it is; `None` if nothing is missing.
    pub fn plan(&self, plan: &WashPlan, index: usize, intent: &Intent) -> Option<Load> {
        let (params, [width, height]) = (self.study.params, self.study.mount.size);
        let Intent { walls, stray, hardness, flat, .. } = intent;
        let open = Raster::by_rows(width, height, |x, y| {
            u8::from(self.study.inside.at(x, y) > 0.0 && self.study.bare.at(x, y) == 0)
        });
        let under = self.seen(&walls.regions, &open);
        let under_lab = in_lab(&under);
        let economy = if index > 0 { (params.economy * params.freedom()) as f32 } else { 0.0 };
        let wanted = Raster::by_rows(width, height, |x, y| {
            let left = (economy * (1.0 - self.study.exact.at(x, y))).min(1.0);
            mixed(intent.wanted.at(x, y), under_lab.at(x, y), left * (1.0 - self.study.graded(x, y)))
        });
        let shapes = if index == 0 {
            open.clone()
        } else {
            let missing = Raster::by_rows(width, height, |x, y| lacking(wanted.at(x, y), under_lab.at(x, y)));
            let missing = self.calmed(&missing, &intent.meant, &walls.regions, flat);
            self.shapes(plan, index, &missing, flat, &walls.regions, stray, &open)
        };
        if shapes.as_slice().iter().all(|&shape| shape == 0) {
            return None;
        }
        let (painted, softness) = self.softened(plan, &shapes, intent, &open, index);
        let numbered = colored(&intent.strayed.regions, &painted);
        let photo = warped(&self.study.photo, stray);
        let (mut shapes_of, mut edges) =
            voted_as_seen(&numbered, &photo, self.study.cells(0.6 * plan.rounding).max(0.8));
        let cells = shapes_of.as_mut_slice().iter_mut().zip(edges.as_mut_slice()).zip(open.as_slice());
        cells.filter(|(_, open)| **open == 0).for_each(|(cell, _)| {
            *cell.1 = if *cell.0 == 0 { *cell.1 } else { 0.0 };
            *cell.0 = 0;
        });
        intent.strayed.open(&shapes_of, &mut edges);
        let amounts = self.amounts(plan, &wanted, &under, &shapes, &shapes_of, stray, &softness, index);
        let moist = gaussian_plane(&softness, self.study.cells(0.012));
        let moist = moist.map(|soft| 1.2 * soft * params.wetness.min(1.5) as f32);
        let water = self.water(plan, hardness, &moist, index);
        Some(Load { shapes: shapes_of, edges, amounts, water, moist })
    }

    /// The sheet as the plan sees it: half blind away from detail, so that it does not repair the accidents of the washes
    /// below; and never across an edge, or every wash would darken its own border.
    fn seen(&self, walls: &Regions, open: &Raster<u8>) -> Colors {
        let current = self.current.map(|color| color.0.map(|channel| channel as f32));
        let freedom = self.study.params.freedom();
        let walled = Raster::by_rows(walls.width(), walls.height(), |x, y| {
            if open.at(x, y) != 0 { walls.at(x, y) } else { u32::MAX }
        });
        let blind = within(&current, &walled, self.study.cells(0.007 * freedom));
        let near = within(&current, &open.map(u32::from), self.study.cells(0.002));
        Raster::by_rows(walls.width(), walls.height(), |x, y| {
            mixed(blind.at(x, y), near.at(x, y), self.study.exact.at(x, y))
        })
    }

    /// What is missing, as the photograph means it where it is flat: what the washes below lack there is looked at from far
    /// away only, as shapes of their unevenness would be islands that nothing in the photograph explains.
    fn calmed(&self, missing: &Plane, meant: &Plane, walls: &Regions, flat: &Plane) -> Plane {
        let [width, height] = self.study.mount.size;
        let besides = Raster::by_rows(width, height, |x, y| [missing.at(x, y) - meant.at(x, y)]);
        let far = within(&besides, walls, self.study.cells(0.06));
        Raster::by_rows(width, height, |x, y| {
            let (near, far) = (missing.at(x, y), meant.at(x, y) + far.at(x, y)[0]);
            near + flat.at(x, y) * (far - near)
        })
    }

    /// Where a later wash is laid.
    #[expect(clippy::too_many_arguments, reason = "all of them are rasters of one wash's plan")]
    fn shapes(
        &self,
        plan: &WashPlan,
        index: usize,
        missing: &Plane,
        flat: &Plane,
        walls: &Regions,
        stray: &Raster<[f32; 2]>,
        open: &Raster<u8>,
    ) -> Raster<u8> {
        let (params, [width, height]) = (self.study.params, self.study.mount.size);
        let missing = within(&missing.map(|need| [need]), walls, self.study.cells(plan.need_over));
        let missing = warped(&missing, stray);
        let chance =
            plane(self.study.seed, &format!("shape {index}"), self.study.mount.size, self.study.cells(0.01));
        let simpler = params.simplification as f32;
        let area = (self.study.cells(1.0) * self.study.cells(1.0)) as f32;
        let over = Raster::by_rows(width, height, |x, y| {
            let exact = self.study.exact.at(x, y);
            let graded = self.study.graded(x, y);
            let need = missing.at(x, y)[0] + 0.9 * chance.at(x, y) * (1.0 - 0.8 * exact) * (1.0 - graded);
            let least = 4.0 - exact + simpler * (1.0 - exact);
            // Where it is flat all that is missing is meant.
            let least = least + flat.at(x, y) * (2.5 - least).min(0.0);
            // What is soft fades in from nothing.
            need - (least + graded * (0.7 - least))
        });
        let mask = Raster::by_rows(width, height, |x, y| open.at(x, y) & u8::from(over.at(x, y) > 0.0));
        let worth = Raster::by_rows(width, height, |x, y| {
            // What is hardly there must be large to be worth a mark, or it would be a scab.
            let faint = (FAINT / (1.0 + over.at(x, y).abs())).clamp(0.8, 3.0);
            plan.least_shape as f32 * area * simpler * faint
        });
        let least =
            Raster::by_rows(width, height, |x, y| worth.at(x, y) * (1.1 - 0.95 * self.study.exact.at(x, y)));
        let holes = Raster::by_rows(width, height, |x, y| {
            // Where little is missing from what is drawn exactly, little is laid: no need to go around it.
            let modelled = 1.0 - smoothstep(self.study.steps.at(x, y), HOLE[0], HOLE[1]);
            0.8 * least.at(x, y) + 5.0 * self.study.exact.at(x, y) * modelled * worth.at(x, y)
        });
        let mask = cleaned(&mask, &least, Some(&holes));
        let mask = mask.map(f32::from);
        let round = gaussian_plane(&mask, self.study.cells(0.8 * plan.need_over));
        // A dry brush skips over hollows at the edges of its mark, and still touches peaks beside it.
        let dragged = gaussian_plane(&mask, self.study.cells(0.005));
        Raster::by_rows(width, height, |x, y| {
            let dry = (params.drybrush as f32 * self.study.rough.at(x, y)).min(1.0);
            let touched = dragged.at(x, y) + 0.9 * (self.paper.at(x, y) - 0.5);
            let there = round.at(x, y) + dry * (touched - round.at(x, y));
            open.at(x, y) & u8::from(there > 0.5)
        })
    }

    /// The shapes, reaching on where the photograph is soft, and how soft that is: paper that is wetted first.
    fn softened(
        &self,
        plan: &WashPlan,
        shapes: &Raster<u8>,
        intent: &Intent,
        open: &Raster<u8>,
        index: usize,
    ) -> (Raster<u8>, Plane) {
        let wetness = self.study.params.wetness as f32;
        let soft = Raster::by_rows(shapes.width(), shapes.height(), |x, y| {
            let hard = smoothstep(intent.hardness.at(x, y) / wetness.max(0.2), 0.15, 0.5);
            // Lost and found: here and there the paper had dried before the brush came again; never where all only fades.
            let found = smoothstep(self.study.found.at(x, y), FOUND[0], FOUND[1]);
            let found = found * (1.0 - intent.flat.at(x, y));
            let hard = if index == 0 { hard } else { hard.max(found / wetness.max(1.0)) };
            ((1.0 - hard) * (1.0 - 0.8 * self.study.exact.at(x, y))).clamp(0.0, 1.0)
                * (plan.softness * wetness).min(1.0)
        });
        if index == 0 {
            return (shapes.clone(), soft);
        }
        let reach = gaussian_plane(&shapes.map(f32::from), self.study.cells(0.0045 * f64::from(wetness)));
        let painted = Raster::by_rows(shapes.width(), shapes.height(), |x, y| {
            let reached = reach.at(x, y) > 0.03 && soft.at(x, y) > 0.3;
            u8::from(open.at(x, y) != 0 && (shapes.at(x, y) != 0 || reached))
        });
        (painted, soft)
    }

    /// How much of each pigment is laid where.
    #[expect(clippy::too_many_arguments, reason = "all of them are rasters of one wash's plan")]
    fn amounts(
        &self,
        plan: &WashPlan,
        wanted: &Colors,
        under: &Colors,
        shapes: &Raster<u8>,
        numbered: &Raster<u8>,
        stray: &Raster<[f32; 2]>,
        softness: &Plane,
        index: usize,
    ) -> Raster<[f32; MOST]> {
        let (params, [width, height]) = (self.study.params, self.study.mount.size);
        let hue = if self.paints.len() == 1 { 0.05 } else { 1.0 };
        let coarse = Limits { each: plan.most_each, total: 2.6, thrift: 4.0, keeping: 0.0, rounds: 14, hue };
        let fine = Limits { keeping: 20.0, rounds: 6, ..coarse };
        let sized = |by: usize| (width.div_ceil(by), height.div_ceil(by));
        let small = |raster: &Colors, by: usize| resized(raster, sized(by).0, sized(by).1);
        let first = separated(self.paints, &small(wanted, 8), &small(under, 8), None, None, &coarse);
        let by = plan.coarseness;
        let start = resized(&first, sized(by).0, sized(by).1);
        let near = dilated(numbered, 2 + self.study.cells(0.006 * params.wobble) as usize);
        let near =
            resized_plane(&near.map(f32::from), sized(by).0, sized(by).1).map(|near| u8::from(near > 0.0));
        let amounts =
            separated(self.paints, &small(wanted, by), &small(under, by), Some(&start), Some(&near), &fine);
        let amounts = warped(&resized(&amounts, width, height), stray);
        if index == 0 {
            return amounts;
        }
        // Shapes step instead of fading in, except where the photograph is soft.
        let masked = Raster::by_rows(width, height, |x, y| {
            let there = f32::from(shapes.at(x, y));
            let mut cell = [0.0; MOST + 1];
            cell[..MOST].copy_from_slice(&amounts.at(x, y).map(|amount| amount * there));
            cell[MOST] = there;
            cell
        });
        let even = within(&masked, numbered, self.study.cells(0.02));
        let faded = gaussian(&masked, self.study.cells(0.0055 * params.wetness));
        Raster::by_rows(width, height, |x, y| {
            let exact = self.study.exact.at(x, y);
            let (own, even, faded) = (amounts.at(x, y), even.at(x, y), faded.at(x, y));
            let step = params.stepping as f32 * (1.0 - 0.7 * exact) * (1.0 - self.study.graded(x, y));
            let soft = softness.at(x, y);
            let is_shape = shapes.at(x, y) != 0;
            core::array::from_fn(|k| {
                let mean = if even[MOST] > 0.01 { even[k] / even[MOST] } else { 0.0 };
                let own = if is_shape { own[k] } else { mean };
                let stepped = own + step * (mean - own);
                stepped + soft * (faded[k] - stepped)
            })
        })
    }

    /// How much water is laid.
    fn water(&self, plan: &WashPlan, hardness: &Plane, moist: &Plane, index: usize) -> Plane {
        let params = self.study.params;
        let uneven =
            plane(self.study.seed, &format!("water {index}"), self.study.mount.size, self.study.cells(0.1));
        let much = 0.2 * params.turbulence as f32;
        let dry_within = self.study.cells(DRY_WITHIN) as f32;
        Raster::by_rows(self.study.mount.size[0], self.study.mount.size[1], |x, y| {
            let film = plan.film * params.wetness.clamp(0.4, 1.6) as f32;
            // Where nothing is hard, less water stands; detail is painted with a nearly dry brush.
            let hard = 0.7 + 0.3 * hardness.at(x, y);
            let exact = 1.0 - 0.45 * self.study.exact.at(x, y);
            // What is rough is painted with a drier one, so that not every mark gets a rim.
            let rough = 1.0 - 0.8 * (params.drybrush as f32 * self.study.rough.at(x, y)).min(1.0);
            // At the border the brush runs dry here and there, and leaves no rim.
            let border = smoothstep(self.study.inside.at(x, y), 0.0, dry_within);
            let rough =
                rough * (1.0 - DRY * (1.0 - border) * smoothstep(uneven.at(x, y), RUN_DRY[0], RUN_DRY[1]));
            // Dry pores drink first; what they take must not be missing beside damp paper, or water runs there and back.
            let drunk = DRUNK * (1.0 - moist.at(x, y)).max(0.0);
            (film * hard * exact * rough * (1.0 + much * uneven.at(x, y)).clamp(0.4, 1.7) + drunk).min(1.0)
        })
    }
}
