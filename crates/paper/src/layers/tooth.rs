//! Soft irregular relief: a fractal sum of gradient noise, round-topped at will.

use girtin_grid::random::stage;

use crate::samples::{Ground, POINTS_PER_MM, Patch};

girtin_params::parameters! {
    /// Soft irregular relief: a fractal sum of gradient noise, round-topped at will.
    pub struct Tooth {
        amount: f64 {
            symbol: "", label: "Amount", unit: "", default: 1.0, hard: (-1.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "Share of the relief. Negative presses in.", source: "custom",
        }
        wavelength_mm: f64 {
            symbol: "", label: "Wavelength", unit: "mm", default: 1.0, hard: (0.13, 50.0), soft: (0.2, 5.0),
            acts: Simulation, doc: "Size of the coarsest features.", source: "custom",
        }
        octaves: u32 {
            symbol: "", label: "Octaves", unit: "", default: 3, hard: (1.0, 8.0), soft: (1.0, 5.0),
            acts: Simulation,
            doc: "How many scales there are, each half of the one before. Those below 0.125 mm are left out.",
            source: "Ebert et al., Texturing & Modeling",
        }
        gain: f64 {
            symbol: "", label: "Gain", unit: "", default: 0.5, hard: (0.0, 1.0), soft: (0.3, 0.7),
            acts: Simulation, doc: "Amplitude of a scale over that of the one before.",
            source: "Ebert et al., Texturing & Modeling",
        }
        stretch: f64 {
            symbol: "", label: "Stretch", unit: "", default: 1.0, hard: (0.1, 10.0), soft: (0.5, 2.0),
            acts: Simulation, doc: "Length of features along the sheet over that across it.", source: "custom",
        }
        pillow: f64 {
            symbol: "", label: "Pillow", unit: "", default: 0.0, hard: (0.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "From even hills and hollows (0) to round bumps between connected valleys (1).",
            source: "custom",
        }
    }
}

/// |n| of gradient noise has about half the deviation of n; this evens them out, so that `pillow` blends by
/// eye.
const PILLOW_GAIN: f32 = 1.8;

/// How wide the valleys between pillows are rounded, in units of the noise.
const VALLEY: f32 = 0.06;

impl Tooth {
    pub(super) fn fill(&self, ground: &Ground, number: usize, patch: &Patch, out: &mut [f32]) {
        let root = libm::sqrt(self.stretch);
        let lattice = ground.lattice([self.wavelength_mm * root, self.wavelength_mm / root]);
        let noise = ground.noise(const { stage("paper tooth") }, number, &lattice);
        let twin = ground.noise(const { stage("paper tooth twin") }, number, &lattice);
        let pillow = self.pillow as f32;
        let width = patch.x.count;
        let mut even = if pillow == 0.0 { Vec::new() } else { vec![0.0; out.len()] };
        let (mut weight, mut scale) = (1.0, 1.0);
        for octave in 0..self.octaves {
            let [sx, sy] = lattice.spacing_mm.map(|spacing| spacing / scale);
            // Two points a wave are the least that can carry it.
            if octave > 0 && sx.max(sy) * POINTS_PER_MM < 2.0 {
                break;
            }
            // Gradient noise is zero at its lattice points, and the eye finds them, the more so in pillows. A
            // second one whose points are in the middle of the first one's cells fills them: together they
            // are nearly stationary.
            let (one, [dx, dy]) = noise.octave(octave);
            let (two, _) = twin.octave(octave);
            let (x, y) = (patch.x.in_units(sx, dx), patch.y.in_units(sy, dy));
            let (middle_x, middle_y) = (patch.x.in_units(sx, dx + 0.5), patch.y.in_units(sy, dy + 0.5));
            if pillow == 0.0 {
                one.add_gradient_block(&x, &y, width, weight, out);
                two.add_gradient_block(&middle_x, &middle_y, width, weight, out);
            } else {
                even.fill(0.0);
                one.add_gradient_block(&x, &y, width, 1.0, &mut even);
                two.add_gradient_block(&middle_x, &middle_y, width, 1.0, &mut even);
                for (value, &n) in out.iter_mut().zip(&even) {
                    // n²/(|n| + v) is |n| with its crease rounded off.
                    let round = n * n / (n.abs() + VALLEY);
                    *value += weight * (n + pillow * (PILLOW_GAIN * round - n));
                }
            }
            weight *= self.gain as f32;
            scale *= 2.0;
        }
    }
}
