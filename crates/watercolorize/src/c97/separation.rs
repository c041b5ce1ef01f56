//! The colors of all stacks of a few thicknesses of each pigment, in a tree.

use std::collections::HashMap;

use girtin_optics::{Coefficients, Layer, LinearRgb, Srgb};
use girtin_params::parameters;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

use super::thickness_steps;

/// Most pigments of one matte.
pub const MAX_PIGMENTS: usize = 4;
/// Most stacks that are tried: 32 thicknesses of four pigments, 101 of three.
pub const MAX_STACKS: usize = 1 << 20;
/// No two colors of the tree are nearer to each other.
pub const COLOR_STEP: f64 = 1.0 / 255.0;

parameters! {
    /// The parameters of color separation.
    pub struct SeparationParams {
        steps: u32 {
            symbol: "m", label: "Thicknesses", unit: "1", default: 20, hard: (2.0, 256.0), soft: (8.0, 40.0),
            acts: Simulation, doc: "How many thicknesses of each pigment are tried. All of them in all combinations are, so three pigments of 20 are 8000 stacks.", source: "C97 §6.2",
        }
        max_thickness: f64 {
            symbol: "", label: "Greatest thickness", unit: "pigment", default: 2.0, hard: (0.001, 100.0), soft: (0.25, 4.0),
            acts: Simulation, doc: "The most of a pigment that is laid. At 1 it is as strong as in its swatch.", source: "custom",
        }
    }
}

/// There are more stacks than can be tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{steps} thicknesses of {pigments} pigments are more than {MAX_STACKS} stacks, or more than {MAX_PIGMENTS} pigments"
)]
pub struct TooManyStacks {
    /// Thicknesses of each pigment.
    pub steps: usize,
    /// Pigments.
    pub pigments: usize,
}

/// Which stack of layers comes nearest to a color.
pub struct ColorSeparation {
    /// Thicknesses of the pigments from the paper up, for each color of the tree.
    stacks: Vec<[f32; MAX_PIGMENTS]>,
    colors: Vec<[f64; 3]>,
    tree: ImmutableKdTree<f64, 3>,
}

impl std::fmt::Debug for ColorSeparation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ColorSeparation").field("colors", &self.colors.len()).finish_non_exhaustive()
    }
}

impl ColorSeparation {
    /// All stacks of `steps` thicknesses of each paint over a ground, without those that look like a thinner one.
    ///
    /// # Source
    /// Curtis et al. 1997, §6.2: all mⁿ combinations, composited layer by layer as in §5.2, in a 3-d tree by red, green and
    /// blue. W2: "the tree is pruned so that the difference between colors is less than 1/255" is read as: of colors nearer to
    /// each other than 1/255 (Euclidean) one is kept, here the one with the least paint in it.
    ///
    /// # Shapes and units
    /// `paints` from the paper up, each with its greatest thickness. Colors are compared encoded, as sRGB 0 to 1: the
    /// paper's were those of a screen.
    ///
    /// # Errors
    /// There are more than [`MAX_PIGMENTS`] paints or [`MAX_STACKS`] stacks.
    pub fn new(
        paints: &[(Coefficients, f64)],
        steps: usize,
        ground: LinearRgb,
    ) -> Result<Self, TooManyStacks> {
        let too_many = TooManyStacks { steps, pigments: paints.len() };
        let count = u32::try_from(paints.len()).ok().and_then(|pigments| steps.checked_pow(pigments));
        let count =
            count.filter(|&count| count <= MAX_STACKS && paints.len() <= MAX_PIGMENTS).ok_or(too_many)?;
        let layers: Vec<Vec<(f64, Layer)>> = paints
            .iter()
            .map(|(paint, max)| {
                let thicknesses = thickness_steps(paint, *max, steps);
                thicknesses.into_iter().map(|thickness| (thickness, paint.layer(thickness))).collect()
            })
            .collect();
        let mut all: Vec<Stack> =
            (0..count).into_par_iter().map(|number| Stack::new(number, &layers, ground)).collect();
        all.sort_by(|a, b| a.total.total_cmp(&b.total).then(a.number.cmp(&b.number)));
        let kept = prune(&all);
        let colors: Vec<[f64; 3]> = kept.iter().map(|stack| stack.color).collect();
        let tree = ImmutableKdTree::new_from_slice(&colors);
        Ok(Self { stacks: kept.iter().map(|stack| stack.thicknesses).collect(), colors, tree })
    }

    /// Number of colors.
    pub fn len(&self) -> usize {
        self.colors.len()
    }

    /// Whether there is no color; never, since bare paper is one.
    pub fn is_empty(&self) -> bool {
        self.colors.is_empty()
    }

    /// The number of the stack that comes nearest to a color.
    pub fn nearest(&self, color: LinearRgb) -> usize {
        let wanted = in_gamut(color.to_srgb());
        self.tree.nearest_one::<SquaredEuclidean>(&wanted).item as usize
    }

    /// Thicknesses of a stack, from the paper up; those beyond the pigments are 0.
    ///
    /// # Panics
    /// There is no such stack.
    pub fn stack(&self, number: usize) -> [f32; MAX_PIGMENTS] {
        self.stacks[number]
    }

    /// Color of a stack.
    ///
    /// # Panics
    /// There is no such stack.
    pub fn color(&self, number: usize) -> Srgb {
        Srgb(self.colors[number])
    }
}

/// Clamped, and what is no number taken for black.
fn in_gamut(color: Srgb) -> [f64; 3] {
    color.0.map(|channel| if channel > 0.0 { channel.min(1.0) } else { 0.0 })
}

struct Stack {
    number: usize,
    total: f64,
    thicknesses: [f32; MAX_PIGMENTS],
    color: [f64; 3],
}

impl Stack {
    /// The stack whose number has the steps of its layers as digits.
    fn new(number: usize, layers: &[Vec<(f64, Layer)>], ground: LinearRgb) -> Self {
        let mut rest = number;
        let mut stack = Self { number, total: 0.0, thicknesses: [0.0; MAX_PIGMENTS], color: [0.0; 3] };
        let mut below =
            Layer { reflectance: ground.0, reflectance_from_below: [0.0; 3], transmittance: [0.0; 3] };
        for (steps, kept) in layers.iter().zip(&mut stack.thicknesses) {
            let (thickness, layer) = steps[rest % steps.len()];
            rest /= steps.len();
            below = layer.over(below);
            stack.total += thickness;
            *kept = thickness as f32;
        }
        stack.color = in_gamut(LinearRgb(below.reflectance).to_srgb());
        stack
    }
}

/// The stacks without those whose color is nearer than [`COLOR_STEP`] to that of one before.
fn prune(stacks: &[Stack]) -> Vec<&Stack> {
    // A lattice as wide as the least distance: whatever is too near lies in one of 27 cells.
    let cell = |color: [f64; 3]| color.map(|channel| (channel / COLOR_STEP) as i16);
    let mut kept: Vec<&Stack> = Vec::new();
    let mut lattice: HashMap<[i16; 3], Vec<u32>> = HashMap::new();
    let offsets: Vec<[i16; 3]> = (0..27).map(|at| [at % 3 - 1, at / 3 % 3 - 1, at / 9 - 1]).collect();
    for stack in stacks {
        let home = cell(stack.color);
        let is_near = |other: &u32| {
            let other = kept[*other as usize].color;
            let square: f64 = stack.color.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum();
            square < COLOR_STEP * COLOR_STEP
        };
        let taken = offsets.iter().any(|offset| {
            let cell = [0, 1, 2].map(|axis| home[axis] + offset[axis]);
            lattice.get(&cell).is_some_and(|others| others.iter().any(is_near))
        });
        if !taken {
            lattice.entry(home).or_default().push(kept.len() as u32);
            kept.push(stack);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use girtin_grid::random::{between, hash, stage};
    use girtin_optics::Library;

    use super::*;

    fn paints(names: &[&str]) -> Vec<(Coefficients, f64)> {
        let library = Library::builtin();
        names.iter().map(|name| (library.get(name).unwrap().coefficients, 2.0)).collect()
    }

    fn distance(a: Srgb, b: Srgb) -> f64 {
        libm::sqrt(a.0.iter().zip(b.0).map(|(a, b)| (a - b) * (a - b)).sum::<f64>())
    }

    #[test]
    fn stacks_of_any_thickness_are_found_again_by_their_color() {
        for names in [
            ["hansa-yellow", "quinacridone-rose", "burnt-umber"],
            ["cerulean-blue", "hookers-green", "french-ultramarine"],
        ] {
            let paints = paints(&names);
            let separation = ColorSeparation::new(&paints, 20, LinearRgb::WHITE).unwrap();
            let (mut sum, mut worst) = (0.0, 0.0f64);
            let count = 2000;
            for number in 0..count {
                let mut color = LinearRgb::WHITE;
                for (at, (paint, max)) in paints.iter().enumerate() {
                    let bits = hash(1, stage("test"), [number, at as i64], 0);
                    color = paint.layer(between(bits, 0.0, *max)).over_ground(color);
                }
                let off = distance(separation.color(separation.nearest(color)), color.to_srgb());
                sum += off;
                worst = worst.max(off);
            }
            let mean = sum / count as f64;
            assert!(
                mean < 1.5 / 255.0 && worst < 12.0 / 255.0,
                "mean {}, worst {}",
                mean * 255.0,
                worst * 255.0
            );
        }
    }

    #[test]
    fn kept_colors_are_their_stacks_and_differ() {
        let paints = paints(&["hansa-yellow", "phthalo-green"]);
        let separation = ColorSeparation::new(&paints, 30, LinearRgb::WHITE).unwrap();
        assert!(separation.len() < 900, "some of the 900 look alike: {}", separation.len());
        for a in 0..separation.len() {
            let stack = separation.stack(a);
            let mut color = LinearRgb::WHITE;
            for ((paint, _), &thickness) in paints.iter().zip(&stack) {
                color = paint.layer(f64::from(thickness)).over_ground(color);
            }
            assert!(distance(color.to_srgb(), separation.color(a)) < 1e-5);
            for b in 0..a {
                assert!(distance(separation.color(a), separation.color(b)) >= COLOR_STEP);
            }
        }
    }

    #[test]
    fn the_nearest_is_the_nearest() {
        let paints = paints(&["quinacridone-rose", "cerulean-blue", "hansa-yellow"]);
        let separation = ColorSeparation::new(&paints, 12, LinearRgb::WHITE).unwrap();
        for number in 0..300 {
            let bits = |axis| hash(2, stage("test"), [number, axis], 0);
            let color = Srgb([0, 1, 2].map(|axis| between(bits(axis), 0.0, 1.0)));
            let found = distance(separation.color(separation.nearest(color.to_linear())), color);
            let best =
                (0..separation.len()).map(|at| distance(separation.color(at), color)).fold(9.0, f64::min);
            assert!(found <= best + 1e-12, "{found} and {best}");
        }
    }

    #[test]
    fn paper_is_nearest_to_paper_and_odd_colors_find_something() {
        let separation = ColorSeparation::new(&paints(&["burnt-umber"]), 20, LinearRgb::WHITE).unwrap();
        assert_eq!(separation.stack(separation.nearest(LinearRgb::WHITE)), [0.0; 4]);
        for odd in [f64::NAN, f64::INFINITY, -5.0, 1e300] {
            assert!(separation.nearest(LinearRgb([odd; 3])) < separation.len());
        }
        // Paints and grounds that make no difference leave one color.
        let clear = [(Coefficients::default(), 1.0); 4];
        assert_eq!(ColorSeparation::new(&clear, 4, LinearRgb::BLACK).unwrap().len(), 1);
    }

    #[test]
    fn too_many_stacks_are_refused() {
        let paint = paints(&["burnt-umber"])[0];
        assert!(ColorSeparation::new(&[paint; 5], 2, LinearRgb::WHITE).is_err());
        let error = ColorSeparation::new(&[paint; 4], 33, LinearRgb::WHITE).unwrap_err();
        assert_eq!(error, TooManyStacks { steps: 33, pigments: 4 });
    }
}
