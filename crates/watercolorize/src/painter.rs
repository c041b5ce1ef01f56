//! Wash by wash: what is missing is found on the sheet as the washes below dried, and just that is laid.

use std::sync::atomic::{AtomicBool, Ordering};

use girtin_grid::blur::{gaussian, gaussian_plane, within};
use girtin_grid::resize::{resized, resized_plane};
use girtin_grid::{Raster, random};
use girtin_optics::kubelka_munk::glaze_row;
use girtin_optics::{LinearRgb, Pigment, Srgb, UnknownPigment};
use girtin_painting::area::{Area, Shape};
use girtin_painting::document::{Event, Glaze, MapName, Outline, SheetSettings};
use girtin_painting::paint::paint_glaze;
use girtin_painting::resolve::{EDGE_STEPS, PlannedSheet};
use girtin_painting::{
    Document, MapChest, PaintConfig, PaintError, Painted, PaintedGlaze, ResolveError, Stock, StoredMap,
};
use girtin_wash::{LivingParams, WashModel};
use rayon::prelude::*;

use crate::abstraction::abstracted;
use crate::accidents::{noise, plane, smoothstep};
use crate::attention::{attention, quantile};
use crate::lines::{ink, light_lines, warped, warped_labels};
use crate::mount::{Mount, Mounting};
use crate::palette::{choose, clusters};
use crate::regions::{self, Finding, Regions, cleaned, colored, dilated, regions, voted};
use crate::separate::{Limits, MOST, Paints, lab, separated};
use crate::settings::PhotoParams;
use crate::tone::{Tones, lifted};
use crate::washes::WashPlan;

/// Color of the bare sheet.
pub const PAPER: Srgb = Srgb([251.0 / 255.0, 249.0 / 255.0, 244.0 / 255.0]);
/// Color of ink.
const INK: Srgb = Srgb([38.0 / 255.0, 34.0 / 255.0, 36.0 / 255.0]);

/// Film that dry pores drink, on average: [`LivingParams::pore_depth`] times the mean of [`LivingParams::capacity`].
const DRUNK: f32 = 0.18;

/// What is to be painted, and how.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// The photograph: linear light, sRGB's primaries.
    pub photo: &'a Raster<[f32; 3]>,
    /// How it is painted.
    pub params: &'a PhotoParams,
    /// Names of pigments; `None`: they are chosen.
    pub palette: Option<&'a [String]>,
    /// Name of the paper.
    pub paper: &'a str,
    /// How it lies on the sheet.
    pub mounting: Mounting,
    /// Seed of all accidents.
    pub seed: u64,
    /// Long edge of the picture without its margin, pixels.
    pub long_edge: u32,
    /// What stays bare paper, 1, over the photograph; any size.
    pub reserve: Option<&'a Raster<f32>>,
    /// How exactly things are drawn, 0 to 1, over the photograph; any size. `None`: it is found.
    pub detail_map: Option<&'a Raster<f32>>,
    /// Title.
    pub title: &'a str,
}

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The photograph is looked at.
    Looking,
    /// Pigments are chosen.
    Palette,
    /// A wash is planned, from 0.
    Planning(usize),
    /// A wash is laid and dries, from 0.
    Washing(usize),
}

/// Who watches the work.
#[derive(Clone, Copy, Default)]
pub struct Watch<'a> {
    /// Set it to end early.
    pub cancel: Option<&'a AtomicBool>,
    /// Called with what is done now, and how much of the whole is done, 0 to 1.
    pub progress: Option<&'a (dyn Fn(Stage, f64) + Sync)>,
}

impl std::fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Watch").finish_non_exhaustive()
    }
}

/// A finished painting: its document, the maps that the document names, and what was simulated.
#[derive(Debug)]
pub struct Painting {
    /// The document.
    pub document: Document,
    /// Its maps.
    pub maps: MapChest,
    /// What every glaze left, as painting the document leaves it again.
    pub painted: Painted,
}

/// Why a photograph is not painted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PhotoError {
    /// A pigment is not in the stock.
    #[error(transparent)]
    Pigment(#[from] UnknownPigment),
    /// The palette has no pigment, or too many.
    #[error("the palette has {0} pigments; 1 to {MOST} are mixed")]
    Palette(usize),
    /// The document cannot be resolved.
    #[error(transparent)]
    Resolve(#[from] ResolveError),
    /// A wash did not run to its end.
    #[error(transparent)]
    Paint(#[from] PaintError),
    /// The caller cancelled.
    #[error("cancelled")]
    Cancelled,
}

/// Paints a photograph.
///
/// # Errors
/// A pigment or the paper is unknown, there is no memory, or the caller cancelled.
pub fn watercolorize(
    request: &Request<'_>,
    stock: &Stock,
    watch: &Watch<'_>,
) -> Result<Painting, PhotoError> {
    let painter = Painter::new(request, stock, watch)?;
    painter.paint()
}

/// Rasters of the sheet's cells.
type Plane = Raster<f32>;
type Colors = Raster<[f32; 3]>;

struct Painter<'a> {
    request: &'a Request<'a>,
    stock: &'a Stock,
    watch: &'a Watch<'a>,
    mount: Mount,
    /// The photograph in Lab, and it abstracted, broadest first.
    abstractions: Vec<Colors>,
    /// How exactly each cell is drawn, with the parameter in it; 0 to 1.
    exact: Plane,
    /// How far inside the painting's border each cell is, cells.
    inside: Plane,
    /// Distance from the photograph's border, negative inside, cells.
    distance: Plane,
    /// What stays bare: 1.
    bare: Raster<u8>,
    /// Masking fluid, if there is any.
    masked: Option<Plane>,
    pigments: Vec<&'a Pigment>,
    paints: Paints,
    document: Document,
    maps: MapChest,
    sheet: PlannedSheet,
    /// The sheet as it is now.
    current: Raster<LinearRgb>,
    glazes: Vec<PaintedGlaze>,
}

/// A wash ready to be laid.
struct Load {
    /// Which shape each cell belongs to, 0 for none, and how far inside it its middle is.
    shapes: Raster<u8>,
    edges: Plane,
    /// Amounts of each pigment.
    amounts: Raster<[f32; MOST]>,
    /// Film.
    water: Plane,
    /// Pore water before the brush comes, volumes.
    moist: Plane,
}

impl<'a> Painter<'a> {
    fn new(request: &'a Request<'a>, stock: &'a Stock, watch: &'a Watch<'a>) -> Result<Self, PhotoError> {
        let say = |stage, part| report(watch, stage, part);
        say(Stage::Looking, 0.0)?;
        let (photo, params) = (request.photo, request.params);
        let mount =
            Mount::new([photo.width(), photo.height()], f64::from(params.plan_cells), &request.mounting);
        let photo_lab = mount.place(photo).map(lab);
        let exact = match request.detail_map {
            Some(map) => mount.place(&map.map(|value| [value])).map(|[value]| value),
            None => attention(&photo_lab, &mount),
        };
        let exact = exact.map(|exact| (exact * params.detail as f32).clamp(0.0, 1.0));
        let simpler = params.simplification;
        let radius = exact.map(|exact| {
            (mount.cells(simpler) * (0.013 * (1.0 - f64::from(exact)) + 0.0022 * f64::from(exact))) as f32
        });
        let times = |by: f32| radius.map(|radius| radius * by);
        let broad = abstracted(&photo_lab, &radius);
        let broadest = abstracted(&broad, &times(2.0));
        let fine = abstracted(&photo_lab, &times(0.5));
        let finest = abstracted(&photo_lab, &times(0.28));
        say(Stage::Palette, 0.1)?;
        let pigments = palette(request, stock, &broad)?;
        let paints = Paints::new(pigments.iter().map(|pigment| &pigment.coefficients));
        let mut document = document(request, &mount);
        let mut maps = MapChest::default();
        let sheet = document.resolve_sheet(stock, &maps)?;
        let inside = mount.painted(&request.mounting, params.vignette as f32, &sheet.height, request.seed);
        let distance = mount.distance();
        if params.ink > 0.0 {
            let drawing = mount_finer(photo, &mount);
            let lines = ink_map(&drawing, &mount, &exact, params.ink as f32, &inside, request.seed);
            maps.0.insert("ink.png".to_owned(), StoredMap::bytes(&lines));
            document.sheet.printed.push((bytes_of(INK).to_linear(), map_area("ink.png")));
        }
        let sheet = document.resolve_sheet(stock, &maps)?;
        let current = ground_of(&sheet);
        let masked = (params.detail > 0.0).then(|| light_lines(&photo_lab, &mount, &exact));
        let mut painter = Self {
            bare: Raster::new(mount.size[0], mount.size[1], 0),
            abstractions: vec![broadest, broad, fine, finest],
            masked,
            request,
            stock,
            watch,
            mount,
            exact,
            inside,
            distance,
            pigments,
            paints,
            document,
            maps,
            sheet,
            current,
            glazes: Vec::new(),
        };
        painter.bare = painter.reserves();
        Ok(painter)
    }

    fn params(&self) -> &'a PhotoParams {
        self.request.params
    }

    fn cells(&self, part: f64) -> f64 {
        self.mount.cells(part)
    }

    fn say(&self, stage: Stage, part: f64) -> Result<(), PhotoError> {
        report(self.watch, stage, part)
    }

    /// White that stays paper: only where most of its edge is hard, so that pale skies fade to paper instead of ending in a
    /// curve; slivers between shapes; and what the caller reserves.
    fn reserves(&self) -> Raster<u8> {
        let [width, height] = self.mount.size;
        let broad = &self.abstractions[1];
        let area = self.cells(1.0) * self.cells(1.0);
        let white = broad.map(|[l, a, b]| f32::from(u8::from(l > 94.0 && libm::hypotf(a, b) < 7.0)));
        let white = gaussian_plane(&white, self.cells(0.003)).map(|white| u8::from(white > 0.5));
        let least = Raster::new(width, height, (1.5e-4 * area) as f32);
        let mut bare = cleaned(&white, &least, 2.0);
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
        if let Some(reserve) = self.request.reserve {
            let reserve = self.mount.place(&reserve.map(|value| [value]));
            let cells = bare.as_mut_slice().iter_mut().zip(reserve.as_slice());
            cells.for_each(|(bare, [reserve])| *bare |= u8::from(*reserve >= 0.5));
        }
        bare
    }

    /// Slivers of paper left between shapes, few, where edges are hard and light and nothing is exact.
    fn slivers(&self, steps: &Plane) -> Raster<u8> {
        let [width, height] = self.mount.size;
        let much = self.params().slivers as f32;
        if much <= 0.0 {
            return Raster::new(width, height, 0);
        }
        let finding = Finding {
            scale: 196.0,
            least_cells: (8e-4 * self.cells(1.0) * self.cells(1.0)) as usize,
            rounding: self.cells(0.004),
            least_step: 26.0,
        };
        let (_, edges) = voted(&regions(&self.abstractions[1], steps, &finding), self.cells(0.002));
        let chance = plane(self.request.seed, "slivers", self.mount.size, self.cells(0.03));
        let light = gaussian(&self.abstractions[1], self.cells(0.004));
        let loose = gaussian_plane(&self.exact, self.cells(0.01));
        let reach = self.cells(0.0022) as f32 * much;
        let there = Raster::from_fn(width, height, |x, y| {
            let chance = (chance.at(x, y) - 0.9).clamp(0.0, 1.2);
            let loose = smoothstep(-loose.at(x, y), -0.4, -0.08);
            let is_light = light.at(x, y)[0] > 45.0 && self.distance.at(x, y) < -self.cells(0.02) as f32;
            u8::from(is_light && edges.at(x, y) < reach * chance * loose)
        });
        let area = (6e-5 * self.cells(1.0) * self.cells(1.0)) as f32;
        cleaned(&there, &Raster::new(width, height, area), 0.0)
    }

    fn paint(mut self) -> Result<Painting, PhotoError> {
        let count = self.params().washes as usize;
        let (low, high) = {
            let light = || {
                let cells = self.abstractions[1].as_slice().iter().zip(self.distance.as_slice());
                cells.filter(|(_, distance)| **distance < 0.0).map(|(lab, _)| lab[0])
            };
            (quantile(light(), 0.03), quantile(light(), 0.97))
        };
        for index in 0..count {
            let part = |of: f64| 0.15 + 0.85 * (index as f64 + of) / count as f64;
            self.say(Stage::Planning(index), part(0.0))?;
            let plan = WashPlan::of(index, count);
            let load = self.plan(&plan, index, low + (high - low) * plan.level);
            self.say(Stage::Washing(index), part(0.4))?;
            if let Some(load) = load {
                self.lay(&plan, index, &load, part(0.4), 0.51 / count as f64)?;
            }
        }
        Ok(Painting {
            document: self.document,
            maps: self.maps,
            painted: Painted { sheet: self.sheet, glazes: self.glazes },
        })
    }

    /// What a wash is to look like, before the sheet below is looked at.
    fn wanted(&self, plan: &WashPlan, index: usize, lightest: f32) -> Colors {
        let tones = Tones::new(self.params());
        let (low, part) = (plan.abstraction as usize, plan.abstraction.fract() as f32);
        let last = self.abstractions.len() - 1;
        let (a, b) = (&self.abstractions[low.min(last)], &self.abstractions[(low + 1).min(last)]);
        let mut wanted = Raster::from_fn(a.width(), a.height(), |x, y| {
            let (a, b) = (a.at(x, y), b.at(x, y));
            let color = tones.of([0, 1, 2].map(|c: usize| a[c] + part * (b[c] - a[c])));
            if plan.level > 0.0 { lifted(color, lightest) } else { color }
        });
        let wetness = self.params().wetness;
        let soft = if index == 0 { 0.012 * wetness } else { 0.002 * (wetness - 1.0).max(0.0) };
        if soft > 0.0 {
            let blurred = gaussian(&wanted, self.cells(soft));
            let share = if index == 0 { 0.4 } else { 1.0 };
            let cells = wanted.as_mut_slice().iter_mut().zip(blurred.as_slice());
            cells.for_each(|(cell, soft)| *cell = mixed(*cell, *soft, share));
        }
        wanted
    }

    /// The sheet as the plan sees it: half blind away from detail, so that it does not repair the accidents of the washes
    /// below; and never across an edge, or every wash would darken its own border.
    fn seen(&self, walls: &Regions, open: &Raster<u8>) -> Colors {
        let current = self.current.map(|color| color.0.map(|channel| channel as f32));
        let freedom = self.params().freedom();
        let walled = Raster::from_fn(walls.width(), walls.height(), |x, y| {
            if open.at(x, y) != 0 { walls.at(x, y) } else { u32::MAX }
        });
        let blind = within(&current, &walled, self.cells(0.007 * freedom));
        let near = within(&current, &open.map(u32::from), self.cells(0.002));
        Raster::from_fn(walls.width(), walls.height(), |x, y| {
            mixed(blind.at(x, y), near.at(x, y), self.exact.at(x, y))
        })
    }

    /// Plans a wash on the sheet as it is; `None` if nothing is missing.
    fn plan(&self, plan: &WashPlan, index: usize, lightest: f32) -> Option<Load> {
        let (params, [width, height]) = (self.params(), self.mount.size);
        let stage = |name: &str| format!("{name} {index}");
        let freedom = params.freedom() as f32;
        let area = self.cells(1.0) * self.cells(1.0);
        let source = &self.abstractions[(plan.abstraction + 0.5) as usize];
        let steps = regions::steps(source, self.cells(0.008));
        let walls = regions(
            source,
            &steps,
            &Finding {
                scale: plan.scale,
                least_cells: (plan.least_region * params.simplification * area) as usize,
                rounding: self.cells(plan.rounding),
                least_step: plan.least_step * params.edge_threshold as f32,
            },
        );
        let open = Raster::from_fn(width, height, |x, y| {
            u8::from(self.inside.at(x, y) > 0.0 && self.bare.at(x, y) == 0)
        });
        let mut wanted = self.wanted(plan, index, lightest);
        let under = self.seen(&walls, &open);
        let under_lab = under.map(lab);
        let even = within(&wanted, &walls, self.cells(plan.flat_over));
        wanted = Raster::from_fn(width, height, |x, y| {
            let exact = self.exact.at(x, y);
            let flat = params.flatness as f32 * plan.flatness * (1.0 - 0.8 * exact);
            let wanted = mixed(wanted.at(x, y), even.at(x, y), flat);
            let left = if index > 0 { params.economy as f32 * freedom * (1.0 - exact) } else { 0.0 };
            mixed(wanted, under_lab.at(x, y), left.min(1.0))
        });
        let missing = Raster::from_fn(width, height, |x, y| {
            let (wanted, under) = (wanted.at(x, y), under_lab.at(x, y));
            let chroma = libm::hypotf(under[1] - wanted[1], under[2] - wanted[2]);
            (under[0] - wanted[0]).max(0.0) + 0.35 * chroma
        });
        let charge = plan.charge * params.charging as f32 * freedom.min(1.0);
        if charge > 0.0 {
            let drift = noise::<2>(self.request.seed, &stage("charging"), self.mount.size, self.cells(0.05));
            for (at, cell) in wanted.as_mut_slice().iter_mut().enumerate() {
                let exact = self.exact.as_slice()[at];
                let much = charge * (1.0 - 0.85 * exact) * smoothstep(100.0 - cell[0], 3.0, 20.0);
                cell[1] += much * drift.as_slice()[at][0];
                cell[2] += much * drift.as_slice()[at][1];
            }
        }
        // One displacement for colors and shapes alike: the slight misregister of glazes.
        let first = if index == 0 { 1.5 } else { 1.0 };
        let amplitude = (self.cells(0.0020) * params.wobble * first) as f32;
        let stray = noise::<2>(self.request.seed, &stage("wobble"), self.mount.size, self.cells(0.025));
        let stray = Raster::from_fn(width, height, |x, y| {
            stray.at(x, y).map(|by| by * amplitude * (1.0 - 0.9 * self.exact.at(x, y)))
        });
        let hardness = self.hardness(&steps);
        let shapes =
            if index == 0 { open.clone() } else { self.shapes(plan, index, &missing, &walls, &stray, &open) };
        if shapes.as_slice().iter().all(|&shape| shape == 0) {
            return None;
        }
        let walls = warped_labels(&walls, &stray);
        let (painted, softness) = self.softened(plan, &shapes, &hardness, &open, index);
        let numbered = colored(&walls, &painted);
        let (mut shapes_of, edges) = voted(&numbered, self.cells(0.6 * plan.rounding).max(0.8));
        shapes_of.as_mut_slice().iter_mut().zip(open.as_slice()).for_each(|(shape, open)| *shape *= open);
        let amounts = self.amounts(plan, &wanted, &under, &shapes, &shapes_of, &stray, &softness, index);
        let moist = gaussian_plane(&softness, self.cells(0.012));
        let moist = moist.map(|soft| 1.2 * soft * params.wetness.min(1.5) as f32);
        let water = self.water(plan, &hardness, &moist, index);
        Some(Load { shapes: shapes_of, edges, amounts, water, moist })
    }

    /// How hard the photograph's edges are around each cell, 0 to 1.
    fn hardness(&self, steps: &Plane) -> Plane {
        let threshold = self.params().edge_threshold as f32;
        let hard = gaussian_plane(steps, 1.0).map(|step| smoothstep(step, 8.0 * threshold, 26.0 * threshold));
        // Spread, so that both sides of an edge know it.
        let wide = gaussian_plane(&hard, self.cells(0.004));
        wide.map(|hard| (2.6 * hard).min(1.0))
    }

    /// Where a later wash is laid.
    fn shapes(
        &self,
        plan: &WashPlan,
        index: usize,
        missing: &Plane,
        walls: &Regions,
        stray: &Raster<[f32; 2]>,
        open: &Raster<u8>,
    ) -> Raster<u8> {
        let (params, [width, height]) = (self.params(), self.mount.size);
        let missing = within(&missing.map(|need| [need]), walls, self.cells(plan.need_over));
        let missing = warped(&missing, stray);
        let chance = plane(self.request.seed, &format!("shape {index}"), self.mount.size, self.cells(0.01));
        let simpler = params.simplification as f32;
        let border = plane(self.request.seed, &format!("border {index}"), self.mount.size, self.cells(0.03));
        let area = (self.cells(1.0) * self.cells(1.0)) as f32;
        let is_open = |x: usize, y: usize| {
            let inside = self.inside.at(x, y) + self.cells(0.0016) as f32 * (border.at(x, y) - 0.4);
            open.at(x, y) != 0 && inside > 0.0
        };
        let mask = Raster::from_fn(width, height, |x, y| {
            let exact = self.exact.at(x, y);
            let need = missing.at(x, y)[0] + 0.9 * chance.at(x, y) * (1.0 - 0.8 * exact);
            u8::from(is_open(x, y) && need > 4.0 - 1.0 * exact + 3.0 * simpler * (1.0 - exact))
        });
        let least = self.exact.map(|exact| plan.least_shape as f32 * area * simpler * (1.1 - 0.95 * exact));
        let mask = cleaned(&mask, &least, 0.8);
        let round = gaussian_plane(&mask.map(f32::from), self.cells(0.8 * plan.need_over));
        Raster::from_fn(width, height, |x, y| u8::from(round.at(x, y) > 0.5 && is_open(x, y)))
    }

    /// The shapes, reaching on where the photograph is soft, and how soft that is: paper that is wetted first.
    fn softened(
        &self,
        plan: &WashPlan,
        shapes: &Raster<u8>,
        hardness: &Plane,
        open: &Raster<u8>,
        index: usize,
    ) -> (Raster<u8>, Plane) {
        let wetness = self.params().wetness as f32;
        let soft = Raster::from_fn(shapes.width(), shapes.height(), |x, y| {
            let hard = smoothstep(hardness.at(x, y) / wetness.max(0.2), 0.15, 0.5);
            ((1.0 - hard) * (1.0 - 0.8 * self.exact.at(x, y))).clamp(0.0, 1.0)
                * (plan.softness * wetness).min(1.0)
        });
        if index == 0 {
            return (shapes.clone(), soft);
        }
        let reach = gaussian_plane(&shapes.map(f32::from), self.cells(0.0045 * f64::from(wetness)));
        let painted = Raster::from_fn(shapes.width(), shapes.height(), |x, y| {
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
        let (params, [width, height]) = (self.params(), self.mount.size);
        let hue = if self.paints.len() == 1 { 0.05 } else { 1.0 };
        let coarse = Limits { each: plan.most_each, total: 2.6, thrift: 4.0, keeping: 0.0, rounds: 14, hue };
        let fine = Limits { keeping: 20.0, rounds: 6, ..coarse };
        let sized = |by: usize| (width.div_ceil(by), height.div_ceil(by));
        let small = |raster: &Colors, by: usize| resized(raster, sized(by).0, sized(by).1);
        let first = separated(&self.paints, &small(wanted, 8), &small(under, 8), None, None, &coarse);
        let by = plan.coarseness;
        let start = resized(&first, sized(by).0, sized(by).1);
        let near = dilated(numbered, 2 + self.cells(0.006 * params.wobble) as usize);
        let near =
            resized_plane(&near.map(f32::from), sized(by).0, sized(by).1).map(|near| u8::from(near > 0.0));
        let amounts =
            separated(&self.paints, &small(wanted, by), &small(under, by), Some(&start), Some(&near), &fine);
        let amounts = warped(&resized(&amounts, width, height), stray);
        if index == 0 {
            return amounts;
        }
        // Shapes step instead of fading in, except where the photograph is soft.
        let masked = Raster::from_fn(width, height, |x, y| {
            let there = f32::from(shapes.at(x, y));
            let mut cell = [0.0; MOST + 1];
            cell[..MOST].copy_from_slice(&amounts.at(x, y).map(|amount| amount * there));
            cell[MOST] = there;
            cell
        });
        let even = within(&masked, numbered, self.cells(0.02));
        let faded = gaussian(&masked, self.cells(0.0055 * params.wetness));
        Raster::from_fn(width, height, |x, y| {
            let exact = self.exact.at(x, y);
            let (own, even, faded) = (amounts.at(x, y), even.at(x, y), faded.at(x, y));
            let step = params.stepping as f32 * (1.0 - 0.7 * exact);
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
        let params = self.params();
        let uneven = plane(self.request.seed, &format!("water {index}"), self.mount.size, self.cells(0.03));
        let much = 0.3 * params.turbulence as f32;
        Raster::from_fn(self.mount.size[0], self.mount.size[1], |x, y| {
            let film = plan.film * params.wetness.clamp(0.4, 1.6) as f32;
            // Where nothing is hard, less water stands; detail is painted with a nearly dry brush.
            let hard = 0.7 + 0.3 * hardness.at(x, y);
            let exact = 1.0 - 0.45 * self.exact.at(x, y);
            // Dry pores drink first; what they take must not be missing beside damp paper, or water runs there and back.
            let drunk = DRUNK * (1.0 - moist.at(x, y)).max(0.0);
            (film * hard * exact * (1.0 + much * uneven.at(x, y)).clamp(0.4, 1.7) + drunk).min(1.0)
        })
    }

    /// Writes a wash into the document, and lets it run and dry.
    fn lay(
        &mut self,
        plan: &WashPlan,
        index: usize,
        load: &Load,
        done: f64,
        share: f64,
    ) -> Result<(), PhotoError> {
        let name = |of: &str| format!("wash-{}-{of}.png", index + 1);
        let mut keep = |file: String, map: StoredMap| {
            let area = map_area(&file);
            self.maps.0.insert(file, map);
            area
        };
        let steps = load.edges.map(|edge| (edge * EDGE_STEPS + 0.5).min(255.0) as u8);
        keep(name("shapes"), StoredMap::Bytes(load.shapes.clone()));
        keep(name("edges"), StoredMap::Bytes(steps));
        let masked = self.masked.as_ref().filter(|_| index > 0).map(|masked| {
            keep(name("masked"), StoredMap::bytes(masked));
            map_name(&name("masked"))
        });
        let turbulence =
            plan.turbulence * (self.request.params.turbulence * self.request.params.freedom()) as f32;
        let [long, short] = [0.035, 0.012].map(|sigma| {
            let stage = format!("load {sigma} {index}");
            plane(self.request.seed, &stage, self.mount.size, self.mount.cells(sigma))
        });
        let mut events = vec![
            Event::Moisten {
                area: keep(name("moist"), StoredMap::bytes(&load.moist.map(|m| m / 2.0))),
                volumes: 2.0,
            },
            Event::Wet { area: Area::default() },
            Event::Water { area: keep(name("water"), StoredMap::bytes(&load.water)), amount: 1.0 },
        ];
        let mut pigments = Vec::new();
        for k in 0..self.pigments.len() {
            let mut amounts = Raster::from_fn(self.mount.size[0], self.mount.size[1], |x, y| {
                let uneven = 1.0 + turbulence * (long.at(x, y) + 0.6 * short.at(x, y));
                let there = f32::from(u8::from(load.shapes.at(x, y) != 0));
                load.amounts.at(x, y)[k] * uneven.clamp(0.4, 1.7) * there
            });
            let most = amounts.as_slice().iter().fold(0.0f32, |most, &amount| most.max(amount));
            if most < 0.004 {
                continue;
            }
            amounts.as_mut_slice().iter_mut().for_each(|amount| *amount /= most);
            let area = keep(name(&self.pigments[k].id), StoredMap::words(&amounts));
            pigments.push((k, area, f64::from(most)));
        }
        for (at, (_, area, most)) in pigments.iter().enumerate() {
            let mut amounts = vec![0.0; pigments.len()];
            amounts[at] = *most;
            events.push(Event::Pigment { area: area.clone(), amounts });
        }
        events.push(Event::Run { steps: 400, until_dry: true, feed: None });
        events.push(Event::Dry { area: None, damp: [0.0, 0.0] });
        let glaze = Glaze {
            name: format!("wash {}", index + 1),
            pigments: pigments.iter().map(|(k, ..)| self.pigments[*k].id.clone()).collect(),
            model: WashModel::Living(self.physics(plan)),
            granulation: plan.granulation * self.request.params.granulation,
            outline: Some(Outline {
                regions: map_name(&name("shapes")),
                edges: Some(map_name(&name("edges"))),
                masked,
            }),
            events,
        };
        let planned = glaze.resolve(&self.sheet, self.stock, &self.maps)?;
        let progress = |steps: u64, of: u64| {
            if let Some(progress) = self.watch.progress {
                // A wash is mostly dry long before its last step.
                let part = (2.0 * steps as f64 / of.max(1) as f64).min(1.0);
                progress(Stage::Washing(index), done + share * part);
            }
        };
        let config =
            PaintConfig { cancel: self.watch.cancel, progress: Some(&progress), ..PaintConfig::default() };
        let painted = paint_glaze(&self.sheet, &glaze, planned, index, &config)?;
        lay_over(&painted, &mut self.current);
        self.document.glazes.push(glaze);
        self.glazes.push(painted);
        Ok(())
    }

    fn physics(&self, plan: &WashPlan) -> LivingParams {
        let params = self.params();
        LivingParams {
            edge_darkening: 2.5 * plan.edge_darkening * params.rims,
            evaporation: 0.006,
            creep_speed: 0.0,
            ..LivingParams::default()
        }
    }
}

/// Tells the watcher, unless it has had enough.
fn report(watch: &Watch<'_>, stage: Stage, part: f64) -> Result<(), PhotoError> {
    if watch.cancel.is_some_and(|cancel| cancel.load(Ordering::SeqCst)) {
        return Err(PhotoError::Cancelled);
    }
    if let Some(progress) = watch.progress {
        progress(stage, part);
    }
    Ok(())
}

/// The pigments that are asked for, or that suit the picture.
fn palette<'a>(
    request: &Request<'_>,
    stock: &'a Stock,
    broad: &Colors,
) -> Result<Vec<&'a Pigment>, PhotoError> {
    if let Some(names) = request.palette {
        if names.is_empty() || names.len() > MOST {
            return Err(PhotoError::Palette(names.len()));
        }
        return Ok(names.iter().map(|name| stock.pigments.get(name)).collect::<Result<_, _>>()?);
    }
    let tones = Tones::new(request.params);
    let clusters = clusters(&broad.map(|color| tones.of(color)), request.seed);
    let paper = PAPER.to_linear().0.map(|channel| channel as f32);
    Ok(choose(stock.pigments.iter(), &clusters, paper, request.params.colors as usize))
}

/// The document before any glaze.
fn document(request: &Request<'_>, mount: &Mount) -> Document {
    let per_mm = f64::from(request.long_edge) / request.mounting.long_edge_mm;
    // Shapes have smooth edges of their own; grain below a pixel is averaged.
    let samples = libm::ceil(0.9 * mount.cells_per_mm / per_mm).clamp(1.0, 8.0) as u32;
    Document {
        title: request.title.to_owned(),
        sheet: SheetSettings {
            size_mm: mount.size_mm,
            paper: request.paper.to_owned(),
            seed: request.seed,
            ground: bytes_of(PAPER).to_linear(),
            printed: Vec::new(),
            pixels_per_mm: per_mm,
            cells_per_pixel: samples,
            cells_per_mm: Some(mount.cells_per_mm),
            trim_mm: mount.trim_mm,
            relief_mm: request.params.relief,
        },
        glazes: Vec::new(),
    }
}

/// A color as a document stores it.
fn bytes_of(color: Srgb) -> Srgb {
    Srgb::from_bytes(color.to_bytes())
}

fn map_name(file: &str) -> MapName {
    MapName { file: file.to_owned(), place: Default::default() }
}

fn map_area(file: &str) -> Area {
    Area { shape: Shape::Map(map_name(file)), ..Area::default() }
}

fn mixed(a: [f32; 3], b: [f32; 3], part: f32) -> [f32; 3] {
    [0, 1, 2].map(|c| a[c] + part * (b[c] - a[c]))
}

/// The bare sheet at its cells, ink included.
fn ground_of(sheet: &PlannedSheet) -> Raster<LinearRgb> {
    let [width, height] = [sheet.height.width(), sheet.height.height()];
    let mut ground = Raster::new(width, height, sheet.ground);
    let canvas = girtin_painting::area::Canvas::whole(&sheet.height, sheet.cells_per_mm, sheet.seed);
    for (color, area, map) in &sheet.printed {
        girtin_painting::composite::print(&mut ground, *color, &area.cover(&canvas, map.as_ref()));
    }
    ground
}

/// Lays what a glaze left over the sheet, cell by cell.
fn lay_over(glaze: &PaintedGlaze, ground: &mut Raster<LinearRgb>) {
    let width = ground.width();
    let (amounts, paints) = (&glaze.dried.amounts, &glaze.plan.paints);
    ground.as_mut_slice().par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        let mut rows: Vec<Vec<f32>> = amounts.iter().map(|amounts| amounts.row(y).to_vec()).collect();
        if let Some(outline) = &glaze.plan.outline {
            let shapes = outline.regions.row(y);
            for row in &mut rows {
                row.iter_mut()
                    .zip(shapes)
                    .for_each(|(amount, &shape)| *amount *= f32::from(u8::from(shape != 0)));
            }
        }
        let rows: Vec<&[f32]> = rows.iter().map(Vec::as_slice).collect();
        glaze_row(paints, &rows, row);
    });
}

/// The photograph on its sheet, twice as fine as its cells, in Lab: lines are thin.
fn mount_finer(photo: &Raster<[f32; 3]>, mount: &Mount) -> (Mount, Colors) {
    let finer = Mount {
        long_edge: 2.0 * mount.long_edge,
        cells_per_mm: 2.0 * mount.cells_per_mm,
        size: mount.size.map(|side| 2 * side),
        origin: 2 * mount.origin,
        photo: mount.photo.map(|side| 2 * side),
        ..mount.clone()
    };
    let colors = finer.place(photo).map(lab);
    (finer, colors)
}

/// The ink drawing: a hand that wavers and presses unevenly.
fn ink_map(
    (mount, lab): &(Mount, Colors),
    _coarse: &Mount,
    exact: &Plane,
    strength: f32,
    inside: &Plane,
    seed: u64,
) -> Plane {
    let [width, height] = mount.size;
    let exact = resized_plane(exact, width, height);
    let inside = resized_plane(inside, width, height);
    let lines = ink(lab, mount, &exact, strength);
    let stray = noise::<2>(seed, "ink wobble", mount.size, mount.cells(0.02));
    let amplitude = mount.cells(0.0012) as f32;
    let stray = stray.map(|by| by.map(|by| by * amplitude));
    let lines = warped(&lines.map(|line| [line]), &stray);
    let pressure = plane(seed, "ink pressure", mount.size, mount.cells(0.02));
    Raster::from_fn(width, height, |x, y| {
        let pressure = (0.85 + 0.3 * pressure.at(x, y)).clamp(0.25, 1.0);
        let there = f32::from(u8::from(inside.at(x, y) > mount.cells(0.002) as f32));
        (lines.at(x, y)[0] * pressure * there * 0.92).clamp(0.0, 1.0)
    })
}

/// A seed's own number, for callers that have none.
pub fn any_seed(of: &[u8]) -> u64 {
    of.iter().fold(1, |key, &byte| random::fold(key, u64::from(byte)))
}
