//! What a wash is asked to do.

use girtin_params::parameters;

parameters! {
    /// The parameters of the wash of Curtis et al. 1997.
    ///
    /// ```
    /// let params = girtin_wash::C97Params { edge_darkening: 0.05, ..Default::default() };
    /// assert_eq!(params.viscosity, 0.1);
    /// ```
    pub struct C97Params {
        viscosity: f64 {
            symbol: "μ", label: "Viscosity", unit: "1", default: 0.1, hard: (0.0, 1.0), soft: (0.0, 0.2),
            acts: Simulation, doc: "How much neighbouring water drags along. More makes slower, rounder flow; above 0.25 it is unstable.", source: "C97 §4.3.1",
        }
        viscous_drag: f64 {
            symbol: "κ", label: "Viscous drag", unit: "1", default: 0.01, hard: (0.0, 1.0), soft: (0.0, 0.1),
            acts: Simulation, doc: "How much the paper slows the water.", source: "C97 §4.3.1",
        }
        edge_darkening: f64 {
            symbol: "η", label: "Edge darkening", unit: "pressure/step", default: 0.02, hard: (0.0, 1.0), soft: (0.0, 0.1),
            acts: Simulation, doc: "How much water is drawn off at the edge, carrying pigment there. The paper uses 0.01 to 0.05.", source: "C97 §4.3.3",
        }
        edge_kernel: u32 {
            symbol: "K", label: "Edge width", unit: "cells", default: 10, hard: (1.0, 200.0), soft: (4.0, 30.0),
            acts: Simulation, doc: "How far from the edge water is still drawn off.", source: "C97 §4.3.3",
        }
        relax_max_sweeps: u32 {
            symbol: "N", label: "Relaxation sweeps", unit: "1", default: 50, hard: (1.0, 10000.0), soft: (1.0, 100.0),
            acts: Simulation, doc: "How often at most a step evens out the flow.", source: "C97 §4.3.2",
        }
        relax_tolerance: f64 {
            symbol: "τ", label: "Relaxation tolerance", unit: "cells/step", default: 0.01, hard: (0.0, 1.0), soft: (0.0, 0.1),
            acts: Simulation, doc: "A step stops evening out once no correction is larger.", source: "C97 §4.3.2",
        }
        relax_rate: f64 {
            symbol: "ξ", label: "Relaxation rate", unit: "1", default: 0.1, hard: (0.0, 1.0), soft: (0.0, 0.25),
            acts: Simulation, doc: "How much of an imbalance a sweep corrects. Above 0.25 it overshoots.", source: "C97 §4.3.2",
        }
        slope_scale: f64 {
            symbol: "", label: "Slope", unit: "cells/step", default: 0.15, hard: (0.0, 10.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How strongly water runs down the paper's grain.", source: "custom (D7)",
        }
    }
}

parameters! {
    /// The parameters of the capillary layer of Curtis et al. 1997.
    pub struct Capillary {
        absorption: f64 {
            symbol: "α", label: "Absorption", unit: "water/step", default: 0.05, hard: (0.0, 1.0), soft: (0.0, 0.2),
            acts: Simulation, doc: "How much water a wet cell soaks into the paper in a step.", source: "C97 §4.6; value custom",
        }
        min_diffusing: f64 {
            symbol: "ε", label: "Least to give", unit: "water", default: 0.1, hard: (0.0, 1.0), soft: (0.0, 0.5),
            acts: Simulation, doc: "Paper with less pore water gives none to its neighbours.", source: "C97 §4.6; value custom",
        }
        min_receiving: f64 {
            symbol: "δ", label: "Least to take", unit: "water", default: 0.01, hard: (0.0, 1.0), soft: (0.0, 0.5),
            acts: Simulation, doc: "Paper with less pore water takes none from its neighbours.", source: "C97 §4.6; value custom",
        }
        wetting_threshold: f64 {
            symbol: "σ", label: "Wetting threshold", unit: "water", default: 0.55, hard: (0.0, 2.0), soft: (0.3, 0.9),
            acts: Simulation, doc: "Paper with more pore water becomes wet again.", source: "C97 §4.6; value custom",
        }
        capacity: [f64; 2] {
            symbol: "c_min, c_max", label: "Capacity", unit: "water", default: [0.3, 0.9], hard: (0.0, 2.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How much water the paper holds in its deepest valleys and on its highest peaks.", source: "C97 §4.1; values custom",
        }
    }
}

/// By which physics a wash moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WashModel {
    /// Curtis et al. 1997, exactly.
    C97 {
        /// Water and pigment.
        params: C97Params,
        /// The capillary layer, if it is on.
        capillary: Option<Capillary>,
    },
}

impl Default for WashModel {
    fn default() -> Self {
        Self::C97 { params: C97Params::default(), capillary: None }
    }
}
