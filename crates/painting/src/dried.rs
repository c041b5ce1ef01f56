//! What a glaze left when its water was gone, ready for the picture.

use girtin_grid::Raster;
use girtin_wash::WashState;

use crate::resolve::PlannedOutline;

/// Pigment on the paper, cell by cell.
#[derive(Clone, Debug)]
pub struct Dried {
    /// Amounts of each pigment. Of a glaze with an outline, every cell of a shape has some, seams included.
    pub amounts: Vec<Raster<f32>>,
    /// How much more of each pigment lies on paper that is higher by 1, as a part of what lies there on average. It is
    /// what the picture's grain follows where it is finer than cells.
    pub grain: Vec<f32>,
}

/// Cells to each side over which grain is told from shade.
const GRAIN_REACH: usize = 2;

/// Mean amount below which grain is not looked for.
const LEAST_AMOUNT: f32 = 1e-3;

/// Times that pigment is carried on into cells which no water reached, a cell each.
const FILLS: usize = 3;

impl Dried {
    /// What is seen of a state: suspended and deposited pigment alike.
    ///
    /// `laid` is what was brushed on of each pigment: what shapes too small for any water keep. `paper` is given where
    /// the picture will be finer than cells.
    pub fn new(
        state: &WashState,
        outline: Option<&PlannedOutline>,
        laid: &[Raster<f32>],
        paper: Option<&Raster<f32>>,
    ) -> Self {
        let layout = state.layout();
        let seen = state.suspended.iter().zip(&state.deposited).map(|(suspended, deposited)| {
            Raster::by_rows(layout.width(), layout.height(), |x, y| {
                suspended.cells(y)[x] + deposited.cells(y)[x]
            })
        });
        let mut amounts: Vec<Raster<f32>> = seen.collect();
        let grain =
            amounts.iter().map(|amounts| paper.map_or(0.0, |paper| grain_of(amounts, outline, paper)));
        let grain = grain.collect();
        if let Some(outline) = outline {
            fill(&mut amounts, outline, laid);
        }
        Self { amounts, grain }
    }
}

/// Gives every cell of a shape the pigment of its neighbours in the shape, where no water came.
fn fill(amounts: &mut [Raster<f32>], outline: &PlannedOutline, laid: &[Raster<f32>]) {
    let (width, height) = (outline.regions.width(), outline.regions.height());
    let mut known = outline.open.clone();
    let cells = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let mut missing: Vec<(usize, usize)> =
        cells.filter(|&(x, y)| outline.regions.at(x, y) != 0 && known.at(x, y) == 0).collect();
    for _ in 0..FILLS {
        let mut found = Vec::new();
        missing.retain(|&(x, y)| {
            let region = outline.regions.at(x, y);
            let (xs, ys) =
                (x.saturating_sub(1)..(x + 2).min(width), y.saturating_sub(1)..(y + 2).min(height));
            let around: Vec<(usize, usize)> = ys
                .flat_map(|y| xs.clone().map(move |x| (x, y)))
                .filter(|&(x, y)| outline.regions.at(x, y) == region && known.at(x, y) != 0)
                .collect();
            if !around.is_empty() {
                found.push(((x, y), around));
                return false;
            }
            true
        });
        for ((x, y), around) in found {
            for amounts in amounts.iter_mut() {
                let sum: f32 = around.iter().map(|&(x, y)| amounts.at(x, y)).sum();
                amounts.row_mut(y)[x] = sum / around.len() as f32;
            }
            known.row_mut(y)[x] = 1;
        }
    }
    for (x, y) in missing {
        amounts.iter_mut().zip(laid).for_each(|(amounts, laid)| amounts.row_mut(y)[x] = laid.at(x, y));
    }
}

/// The slope of relative amount over height, by least squares over cells well inside a shape.
fn grain_of(amounts: &Raster<f32>, outline: Option<&PlannedOutline>, paper: &Raster<f32>) -> f32 {
    let (width, height) = (amounts.width(), amounts.height());
    let (mut both, mut square) = (0.0f64, 0.0f64);
    let weight = 1.0 / ((2 * GRAIN_REACH + 1) * (2 * GRAIN_REACH + 1)) as f32;
    // Every other cell is plenty.
    for y in (GRAIN_REACH..height.saturating_sub(GRAIN_REACH)).step_by(2) {
        for x in (GRAIN_REACH..width.saturating_sub(GRAIN_REACH)).step_by(2) {
            let (mut amount, mut level, mut inside) = (0.0, 0.0, true);
            for y in y - GRAIN_REACH..=y + GRAIN_REACH {
                let columns = x - GRAIN_REACH..=x + GRAIN_REACH;
                amount += amounts.row(y)[columns.clone()].iter().sum::<f32>();
                level += paper.row(y)[columns.clone()].iter().sum::<f32>();
                inside &=
                    outline.is_none_or(|outline| outline.open.row(y)[columns].iter().all(|&open| open != 0));
            }
            if inside && amount * weight > LEAST_AMOUNT {
                let relative = f64::from(amounts.at(x, y) / (amount * weight) - 1.0);
                let higher = f64::from(paper.at(x, y) - level * weight);
                both += relative * higher;
                square += higher * higher;
            }
        }
    }
    if square > 0.0 { (both / square) as f32 } else { 0.0 }
}
