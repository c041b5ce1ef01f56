//! How much of each pigment is wanted where.

use std::sync::atomic::{AtomicBool, Ordering};

use girtin_grid::Raster;
use girtin_optics::LinearRgb;
use rayon::prelude::*;

use super::ColorSeparation;
use super::separation::MAX_PIGMENTS;

/// Paper that a matte covers this much is wetted.
pub const WETTED: f32 = 0.5;

/// No stack: the pixel lies outside the matte.
const OUTSIDE: u32 = u32::MAX;

/// The target glaze of each pigment: the thicknesses whose stack comes nearest to each pixel of the picture.
///
/// # Source
/// Curtis et al. 1997, §6.2: "searching the tree for each pixel".
///
/// # Shapes and units
/// `picture` and `matte` of one size; the matte is at least [`WETTED`] where a target is wanted, elsewhere it is
/// 0. The result is one
/// raster for each of `pigments`, from the paper up; `None` when `cancel` was set.
///
/// # Guarantees
/// The same for any number of threads (`targets_do_not_depend_on_threads`).
///
/// # Panics
/// The matte has another size than the picture.
///
/// # Cost
/// A search a pixel; runs of one color cost one.
pub fn target_glazes(
    picture: &Raster<LinearRgb>,
    matte: &Raster<f32>,
    separation: &ColorSeparation,
    pigments: usize,
    cancel: Option<&AtomicBool>,
) -> Option<Vec<Raster<f32>>> {
    let (width, height) = (picture.width(), picture.height());
    assert_eq!((width, height), (matte.width(), matte.height()), "sizes of picture and matte");
    let mut nearest = Raster::new(width, height, OUTSIDE);
    if width > 0 {
        nearest.as_mut_slice().par_chunks_mut(width).enumerate().for_each(|(y, nearest)| {
            if cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed)) {
                return;
            }
            let mut last = None;
            for ((nearest, &color), &matte) in nearest.iter_mut().zip(picture.row(y)).zip(matte.row(y)) {
                if matte >= WETTED {
                    *nearest = match last {
                        Some((known, found)) if known == color => found,
                        _ => separation.nearest(color) as u32,
                    };
                    last = Some((color, *nearest));
                }
            }
        });
    }
    if cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed)) {
        return None;
    }
    let thickness = |pigment: usize| {
        nearest.map(|stack| if stack == OUTSIDE { 0.0 } else { separation.stack(stack as usize)[pigment] })
    };
    Some((0..pigments.min(MAX_PIGMENTS)).map(thickness).collect())
}

#[cfg(test)]
mod tests {
    use girtin_optics::Library;

    use super::*;

    fn separation() -> ColorSeparation {
        let library = Library::builtin();
        let paint = |name: &str| (library.get(name).unwrap().coefficients, 2.0);
        let paints = [paint("hansa-yellow"), paint("quinacridone-rose"), paint("cerulean-blue")];
        ColorSeparation::new(&paints, 12, LinearRgb::WHITE).unwrap()
    }

    fn picture() -> Raster<LinearRgb> {
        Raster::from_fn(31, 23, |x, y| {
            LinearRgb([x as f64 / 31.0, y as f64 / 23.0, ((x * y) % 7) as f64 / 7.0])
        })
    }

    #[test]
    fn targets_do_not_depend_on_threads() {
        let (picture, separation) = (picture(), separation());
        let matte = Raster::from_fn(31, 23, |x, y| if (x + y) % 5 == 0 { 0.0 } else { 0.5 });
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| target_glazes(&picture, &matte, &separation, 3, None)).unwrap()
        };
        let one = run(1);
        assert_eq!(one.len(), 3);
        assert!(run(2) == one && run(7) == one);
        assert!(one.iter().all(|glaze| glaze.at(0, 0) == 0.0 && glaze.at(3, 2) == 0.0), "outside the matte");
    }

    #[test]
    fn a_cancelled_search_has_no_result() {
        let (picture, matte) = (picture(), Raster::new(31, 23, 1.0));
        assert!(target_glazes(&picture, &matte, &separation(), 3, Some(&AtomicBool::new(true))).is_none());
    }
}
