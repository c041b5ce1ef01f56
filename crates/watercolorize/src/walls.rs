//! Walls: along the photograph's hard edges the shapes of a wash keep apart, and pigment gathers there.

use girtin_grid::Raster;
use girtin_grid::morphology::dilated;

use crate::lines::{warped, warped_labels};
use crate::regions::{FARTHEST, Finding, Regions, regions};
use crate::study::{Colors, Plane, Study};
use crate::washes::WashPlan;

/// Part of the step over a whole border from which on a stretch of it is a wall.
const WALL: f32 = 0.8;

/// Regions of a wash, and where between them walls stand.
pub struct Walls {
    /// What walls can stand between.
    pub regions: Regions,
    /// How hard the edge at each cell is, Lab.
    hard: Plane,
    /// From which on it is a wall.
    least: f32,
}

impl Walls {
    /// The walls in an abstraction of the photograph; `steps` is how much that changes around each cell.
    pub fn find(study: &Study<'_>, plan: &WashPlan, source: &Colors, steps: &Plane) -> Self {
        // A blurred edge is no wall, however far its sides are apart, and neither is one that only the abstraction has.
        let hard = Raster::by_rows(source.width(), source.height(), |x, y| {
            steps.at(x, y).min(study.steps.at(x, y)) * study.sharp.at(x, y)
        });
        let finding = Finding {
            scale: plan.scale,
            least_cells: study.area(plan.least_region * study.params.simplification) as usize,
            rounding: study.cells(plan.rounding),
            least_step: plan.least_step * study.params.edge_threshold as f32,
        };
        Self { regions: regions(source, &hard, &finding), hard, least: WALL * finding.least_step }
    }

    /// The same with everything displaced by `stray`.
    pub fn warped(&self, stray: &Raster<[f32; 2]>) -> Self {
        let hard = warped(&self.hard.map(|hard| [hard]), stray).map(|[hard]| hard);
        Self { regions: warped_labels(&self.regions, stray), hard, least: self.least }
    }

    /// Opens borders between shapes wherever they are no walls: there `edges` then says that no edge is near.
    pub fn open(&self, shapes: &Raster<u8>, edges: &mut Plane) {
        let beside_none = dilated(&shapes.map(|shape| u8::from(shape == 0)), 2);
        let cells = edges.as_mut_slice().iter_mut().zip(self.hard.as_slice()).zip(beside_none.as_slice());
        for ((edge, &hard), &beside_none) in cells {
            if beside_none == 0 && hard < self.least {
                *edge = FARTHEST;
            }
        }
    }
}
