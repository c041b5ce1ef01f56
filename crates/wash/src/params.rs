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

parameters! {
    /// The parameters of the living wash, Girtin's own model.
    ///
    /// Lengths are millimetres of paper and times reference steps, so they mean the same at any resolution; `symbol` is
    /// the name in `fidelity/wash/living.py`, the model written out in f64.
    pub struct LivingParams {
        compressibility: f64 {
            symbol: "B", label: "Compressibility", unit: "1", default: 0.4, hard: (0.001, 10.0), soft: (0.1, 1.0),
            acts: Simulation, doc: "How much water piles up before the flow turns aside. Less makes sharper, darker edges.", source: "custom; C97 §4.3.2 sweeps 1 to 4 times at ξ 0.1",
        }
        viscosity: f64 {
            symbol: "mu", label: "Viscosity", unit: "mm²/step", default: 0.00625, hard: (0.0, 0.05), soft: (0.0, 0.0125),
            acts: Simulation, doc: "How much neighbouring water drags along. More makes slower, rounder flow.", source: "C97 §4.3.1, 0.1 cells²",
        }
        viscous_drag: f64 {
            symbol: "kappa", label: "Viscous drag", unit: "1", default: 0.01, hard: (0.0, 1.0), soft: (0.0, 0.1),
            acts: Simulation, doc: "How much the paper slows the water.", source: "C97 §4.3.1",
        }
        slope_scale: f64 {
            symbol: "slope", label: "Slope", unit: "0.25 mm/step", default: 0.3, hard: (0.0, 10.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How strongly water runs down the paper's grain.", source: "custom (D7)",
        }
        slope_band: f64 {
            symbol: "", label: "Slope's grain", unit: "mm", default: 0.25, hard: (0.0, 10.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "Grain finer than this does not push the water; it still holds pigment. At 0 all of it pushes.", source: "custom",
        }
        speed_limit: f64 {
            symbol: "cap", label: "Speed limit", unit: "mm/step", default: 0.25, hard: (0.01, 10.0), soft: (0.1, 1.0),
            acts: Simulation, doc: "No water is driven faster, however much is poured on.", source: "custom",
        }
        flowing_film: f64 {
            symbol: "w_flow", label: "Flowing film", unit: "film", default: 0.15, hard: (0.001, 10.0), soft: (0.05, 0.5),
            acts: Simulation, doc: "A film this deep flows freely; a thinner one is held by the paper.", source: "custom",
        }
        least_mobility: f64 {
            symbol: "m_min", label: "Least mobility", unit: "1", default: 0.1, hard: (0.001, 1.0), soft: (0.01, 0.5),
            acts: Simulation, doc: "What a vanishing film keeps of its speed in a step.", source: "custom",
        }
        pigment_diffusion: f64 {
            symbol: "diff", label: "Pigment diffusion", unit: "mm²/step", default: 0.001875, hard: (0.0, 0.05), soft: (0.0, 0.02),
            acts: Simulation, doc: "How fast suspended pigment evens out by itself. It gives rims their width.", source: "custom",
        }
        pigment_dispersion: f64 {
            symbol: "disperse", label: "Pigment dispersion", unit: "mm", default: 0.0375, hard: (0.0, 0.25), soft: (0.0, 0.1),
            acts: Simulation, doc: "Over which length flowing water mixes the pigment it carries. More makes softer edges on wet paper.", source: "custom",
        }
        packing_limit: f64 {
            symbol: "pack", label: "Packing limit", unit: "pigment", default: 1.2, hard: (0.01, 100.0), soft: (0.5, 3.0),
            acts: Simulation, doc: "A place with this much pigment takes no more from the water. Less makes wider, paler rims.", source: "custom",
        }
        edge_darkening: f64 {
            symbol: "eta", label: "Edge darkening", unit: "film/step", default: 0.02, hard: (0.0, 1.0), soft: (0.0, 0.1),
            acts: Simulation, doc: "How much water evaporates at the edge of the wet paper, drawing pigment there.", source: "C97 §4.3.3",
        }
        edge_width: f64 {
            symbol: "K", label: "Edge width", unit: "mm", default: 2.5, hard: (0.01, 50.0), soft: (0.5, 8.0),
            acts: Simulation, doc: "Width of the window that finds the edge; it dries faster within half of it.", source: "C97 §4.3.3, 10 cells",
        }
        evaporation: f64 {
            symbol: "evap", label: "Evaporation", unit: "film/step", default: 0.002, hard: (0.0, 1.0), soft: (0.0, 0.01),
            acts: Simulation, doc: "How much of the film dries in a step.", source: "custom",
        }
        pore_evaporation: f64 {
            symbol: "evap_s", label: "Pore evaporation", unit: "saturation/step", default: 0.0004, hard: (0.0, 1.0), soft: (0.0, 0.005),
            acts: Simulation, doc: "How much of the pores' water dries in a step where no film covers it.", source: "custom",
        }
        pore_depth: f64 {
            symbol: "zeta", label: "Pore depth", unit: "film/saturation", default: 0.3, hard: (0.001, 10.0), soft: (0.1, 1.0),
            acts: Simulation, doc: "How deep a film the water of full pores would make.", source: "custom",
        }
        rim_exponent: u32 {
            symbol: "rim_expo", label: "Damp edge", unit: "1", default: 4, hard: (1.0, 64.0), soft: (1.0, 20.0),
            acts: Simulation, doc: "How nearly full pores must be to end the edge of a film. More makes dark edges on damper paper.", source: "custom",
        }
        settling: f64 {
            symbol: "settle", label: "Settling", unit: "1/step", default: 0.1, hard: (0.0, 1.0), soft: (0.0, 0.5),
            acts: Simulation, doc: "How fast a vanishing film drops its pigment.", source: "custom",
        }
        lifting: f64 {
            symbol: "lift", label: "Lifting", unit: "1", default: 4.0, hard: (0.0, 100.0), soft: (0.0, 10.0),
            acts: Simulation, doc: "How much more easily than in C97 paint that has settled comes up again.", source: "custom; C97 §4.5 has 1",
        }
        absorption: f64 {
            symbol: "alpha", label: "Absorption", unit: "saturation/step", default: 0.02, hard: (0.0, 1.0), soft: (0.0, 0.2),
            acts: Simulation, doc: "How much of the film soaks into the pores in a step.", source: "C97 §4.6; value custom",
        }
        min_diffusing: f64 {
            symbol: "eps", label: "Least to give", unit: "saturation", default: 0.05, hard: (0.0, 1.0), soft: (0.0, 0.5),
            acts: Simulation, doc: "Paper with less pore water gives none to its neighbours.", source: "C97 §4.6; value custom",
        }
        min_receiving: f64 {
            symbol: "delta", label: "Least to take", unit: "saturation", default: 0.02, hard: (0.0, 1.0), soft: (0.0, 0.5),
            acts: Simulation, doc: "Paper with less pore water takes none from its neighbours.", source: "C97 §4.6; value custom",
        }
        capacity: [f64; 2] {
            symbol: "cmin, cmax", label: "Capacity", unit: "saturation", default: [0.3, 0.9], hard: (0.001, 2.0), soft: (0.1, 1.0),
            acts: Simulation, doc: "How much water the paper holds in its deepest valleys and on its highest peaks.", source: "C97 §4.1; values custom",
        }
        wetting_film: f64 {
            symbol: "w_on", label: "Wetting film", unit: "film", default: 0.06, hard: (0.0, 10.0), soft: (0.02, 0.2),
            acts: Simulation, doc: "A film must stand this high to creep over paper whose pores are full.", source: "custom",
        }
        drying_film: f64 {
            symbol: "w_off", label: "Drying film", unit: "film", default: 0.01, hard: (0.0001, 1.0), soft: (0.002, 0.05),
            acts: Simulation, doc: "A film thinner than this is gone; over peaks it tears sooner than in valleys.", source: "custom",
        }
        pinning: f64 {
            symbol: "pin", label: "Pinning", unit: "film", default: 2.0, hard: (0.0, 100.0), soft: (0.0, 5.0),
            acts: Simulation, doc: "How much higher a film must stand to creep over dry paper.", source: "custom",
        }
        pin_roughness: f64 {
            symbol: "rough", label: "Pinning by grain", unit: "1", default: 0.5, hard: (0.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How much more peaks hold an edge than valleys do.", source: "custom",
        }
        creep_speed: f64 {
            symbol: "creep", label: "Creep", unit: "mm/step", default: 0.0625, hard: (0.0, 1.0), soft: (0.0, 0.25),
            acts: Simulation, doc: "How fast an edge can advance.", source: "custom",
        }
        creep_share: f64 {
            symbol: "share", label: "Creep's share", unit: "1", default: 0.5, hard: (0.01, 0.99), soft: (0.1, 0.9),
            acts: Simulation, doc: "How much of its film a wet place gives to the paper it wets.", source: "custom",
        }
        tilt: f64 {
            symbol: "tilt", label: "Tilt", unit: "°", default: 0.0, hard: (0.0, 90.0), soft: (0.0, 45.0),
            acts: Simulation, doc: "How steeply the board leans; water runs down it.", source: "custom",
        }
        tilt_toward: f64 {
            symbol: "", label: "Tilted toward", unit: "°", default: 90.0, hard: (-360.0, 360.0), soft: (0.0, 360.0),
            acts: Simulation, doc: "Where down is on a tilted board: 0 to the right, 90 to the bottom.", source: "custom",
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
    /// Girtin's own: one amount of water in film and pores, in millimetres, drying by itself.
    Living(LivingParams),
}

impl WashModel {
    /// C97 with the paper's values and the capillary layer off.
    pub fn c97() -> Self {
        Self::C97 { params: C97Params::default(), capillary: None }
    }

    /// The living wash with its own values.
    pub fn living() -> Self {
        Self::Living(LivingParams::default())
    }
}

impl Default for WashModel {
    fn default() -> Self {
        Self::living()
    }
}
