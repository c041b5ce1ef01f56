//! What is asked of each wash, from the first, pale and wide, to the last, dark and small.

/// One wash's share of the painting. Lengths are parts of the photograph's long edge, S; areas of S²; colors Lab.
#[derive(Clone, Copy, Debug)]
pub struct WashPlan {
    /// Which of the abstractions it paints, 0 the broadest to 3 the finest.
    pub abstraction: f64,
    /// How far down it paints, as a part of the picture's range of lightness.
    pub level: f32,
    /// Scale of the first segmentation, and least area of a region.
    pub scale: f32,
    /// Least area of a region.
    pub least_region: f64,
    /// Rounding of region borders.
    pub rounding: f64,
    /// Step of an edge that stops the water.
    pub least_step: f32,
    /// How far its color is evened out inside its edges, and how much.
    pub flat_over: f64,
    /// How much of the evened color is taken.
    pub flatness: f32,
    /// Least area of a shape; none for the first wash, which covers all.
    pub least_shape: f64,
    /// Smoothing of what is missing.
    pub need_over: f64,
    /// Most of one pigment, thickness.
    pub most_each: f32,
    /// Film, and edge darkening.
    pub film: f32,
    /// Edge darkening, film a step.
    pub edge_darkening: f64,
    /// How much water follows the paper's slopes, 0.25 mm a step: the grain of deep washes is their pigments' only.
    pub slope: f64,
    /// Unevenness of what is laid.
    pub turbulence: f32,
    /// Share of the pigments' granulation.
    pub granulation: f64,
    /// How far shapes fade where the photograph is soft: the first washes are laid wet, the last on dry paper.
    pub softness: f32,
    /// Cells of the plan to one of the separation.
    pub coarseness: usize,
}

impl WashPlan {
    /// Wash `index` of `count`.
    pub fn of(index: usize, count: usize) -> Self {
        let last = count.saturating_sub(1);
        // Where it lies between the first and the last of four washes that these numbers were found for.
        let place = if last == 0 { 3.0 } else { 3.0 * index as f64 / last as f64 };
        let between = |values: [f64; 4]| {
            let low = (place as usize).min(2);
            values[low] + (place - low as f64) * (values[low + 1] - values[low])
        };
        // Areas and scales fall by factors.
        let falling = |values: [f64; 4]| libm::exp(between(values.map(libm::log)));
        let level = 1.04 * (1.0 - (index + 1) as f64 / count as f64);
        Self {
            abstraction: if last == 0 { 2.0 } else { place },
            level: if index == last { 0.0 } else { level as f32 },
            scale: falling([196.0, 86.0, 47.0, 24.0]) as f32,
            least_region: falling([8e-4, 2.5e-4, 8e-5, 3e-5]),
            rounding: falling([0.005, 0.004, 0.0025, 0.0018]),
            least_step: falling([30.0, 13.0, 9.0, 8.0]) as f32,
            flat_over: falling([0.03, 0.022, 0.014, 0.008]),
            flatness: between([0.9, 0.85, 0.65, 0.4]) as f32,
            least_shape: falling([6e-4, 4e-4, 1.6e-4, 5e-5]),
            need_over: falling([0.0032, 0.0028, 0.0018, 0.0011]),
            most_each: between([0.8, 1.2, 1.5, 1.8]) as f32,
            film: between([0.55, 0.45, 0.4, 0.35]) as f32,
            edge_darkening: between([0.012, 0.016, 0.016, 0.012]),
            slope: between([0.2, 0.1, 0.1, 0.1]),
            turbulence: between([0.12, 0.08, 0.06, 0.05]) as f32,
            granulation: between([1.0, 0.7, 0.5, 0.4]),
            softness: between([1.0, 0.8, 0.55, 0.35]) as f32,
            coarseness: if place < 1.5 {
                3
            } else if place < 2.5 {
                2
            } else {
                1
            },
        }
    }
}
