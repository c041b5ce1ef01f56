//! Where mattes lie side by side.

use girtin_grid::Raster;
use girtin_grid::morphology::dilated;

use super::MatteGlazes;
use super::stretch::stretched;
use super::target_glaze::WETTED;
use crate::mattes::Matte;

/// How far from the other matte pigment piles up along a seam, cells: as far as a bead that the flow outward makes.
const REACH: usize = 3;

/// The paper that each matte of a file wets.
#[derive(Clone, Debug)]
pub(super) struct Seams {
    names: Vec<String>,
    wetted: Vec<Raster<bool>>,
}

impl Seams {
    /// Of mattes in the order of the file, on so many cells.
    pub fn new(glazes: &[MatteGlazes], mattes: &[&Matte], width: usize, height: usize) -> Self {
        let wetted = mattes
            .iter()
            .map(|matte| stretched(&matte.coverage, width, height).map(|covered| covered >= WETTED));
        Self { names: glazes.iter().map(|glazes| glazes.name.clone()).collect(), wetted: wetted.collect() }
    }

    /// Cells of a matte near paper that another wets and this one does not.
    pub fn of(&self, matte: usize) -> Raster<bool> {
        let own = &self.wetted[matte];
        let mut beside = own.map(|_| false);
        for (name, other) in self.names.iter().zip(&self.wetted) {
            // A matte may be painted twice.
            if *name != self.names[matte] {
                let cells = beside.as_mut_slice().iter_mut().zip(other.as_slice()).zip(own.as_slice());
                cells.for_each(|((beside, other), own)| *beside |= other & !own);
            }
        }
        let near = dilated(&beside.map(u8::from), REACH);
        Raster::from_fn(own.width(), own.height(), |x, y| own.at(x, y) && near.at(x, y) != 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::c97::GlazesFile;

    #[test]
    fn a_seam_is_where_another_matte_begins() {
        let text = "format = 1\n[[matte]]\nname = 'a'\npigments = ['sepia']\n[[matte]]\nname = 'b'\npigments = ['sepia']\n\
            [[matte]]\nname = 'a'\npigments = ['viridian']\n";
        let file = GlazesFile::from_toml("", text, &girtin_painting::Stock::builtin()).unwrap();
        let matte = |name: &str, from: usize, to: usize| Matte {
            name: name.to_owned(),
            coverage: Raster::from_fn(30, 4, |x, _| f32::from(u8::from((from..to).contains(&x)))),
        };
        // Paper is left on both sides, and the mattes overlap in two columns.
        let (a, b) = (matte("a", 2, 16), matte("b", 14, 25));
        let seams = Seams::new(&file.mattes, &[&a, &b, &a], 30, 4);
        let columns = |matte| (0..30).filter(|&x| seams.of(matte).at(x, 2)).collect::<Vec<_>>();
        assert_eq!(columns(0), [13, 14, 15]);
        assert_eq!(columns(1), [14, 15, 16]);
        assert_eq!(columns(2), columns(0), "painted twice, it is no other");
    }
}
