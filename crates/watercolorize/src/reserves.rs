//! What stays bare paper: whites, slivers between shapes, and what the caller reserves.

use girtin_grid::Raster;
use girtin_grid::blur::{gaussian, gaussian_plane};

use crate::accidents::{plane, smoothstep};
use crate::regions::{self, Finding, cleaned, regions, voted};
use crate::study::{Plane, Study};

/// Part of a light surface that must be white for all of it to stay bare.
const WHITE: f64 = 0.6;

/// Over how much of the long edge light surfaces are judged together, and soft rims and hard ones.
const TOGETHER: f64 = 0.04;
const ALONG_RIMS: f64 = 0.025;

/// Part of a white surface's rim that may be soft.
const SOFT: f64 = 0.35;

/// Half the width of a thin surface, a part of the long edge, and how light, Lab, the photograph is beyond its ends, on which
/// part of its rim, where it is a piece of a longer one: a row of such pieces would be lozenges.
const THIN: f64 = 0.006;
const LIGHT_BEYOND: f32 = 88.0;
const CUT: f64 = 0.03;

/// A light surface: its cells, how white they and those around them are, and cells at its rim, and at a soft rim.
#[derive(Clone, Copy, Debug, Default)]
struct Surface {
    cells: u32,
    white: f64,
    rim: u32,
    soft: u32,
    /// Cells of its rim beyond which the photograph is as light.
    cut: u32,
}

impl Surface {
    /// Whether it stays bare paper; `thin` is half the width of a thin one, cells.
    fn is_reserved(&self, thin: f64) -> bool {
        let [cells, rim, soft, cut] = [self.cells, self.rim.max(1), self.soft, self.cut].map(f64::from);
        let is_piece = cells < thin * rim && cut > CUT * rim;
        self.white > WHITE * cells && soft <= SOFT * rim && !is_piece
    }
}

impl Study<'_> {
    /// White that stays paper: only where most of its edge is hard, so that pale skies fade to paper instead of ending in a
    /// curve; slivers between shapes; and what the caller reserves.
    pub fn reserves(&self, reserve: Option<&Plane>) -> Raster<u8> {
        let [width, height] = self.mount.size;
        let broad = &self.abstractions[1];
        let finest = &self.abstractions[3];
        // Fine lights are white by themselves where all is exact; elsewhere only in what is white at large. What is written
        // on white is never white.
        let is_light =
            |[l, a, b]: [f32; 3], least: f32, grayest: f32| l > least && libm::hypotf(a, b) < grayest;
        let lighter = |below: f32, grayest: f32| {
            Raster::by_rows(width, height, |x, y| {
                let at_large = is_light(broad.at(x, y), 94.0 - below, grayest) || self.exact.at(x, y) > 0.3;
                u8::from(at_large && is_light(finest.at(x, y), 92.5 - below, grayest))
            })
        };
        let white = lighter(0.0, 7.0);
        // A surface is white or it is not: where all of one is nearly so, all of it stays bare.
        let light = lighter(5.0, 9.0);
        let round = gaussian_plane(&light.map(f32::from), self.cells(0.003));
        let light = Raster::by_rows(width, height, |x, y| {
            light.at(x, y) & u8::from(self.exact.at(x, y) > 0.3 || round.at(x, y) > 0.5)
        });
        let least = self.exact.map(|exact| self.area(1.5e-4) as f32 * (1.2 - 0.75 * exact));
        let mut bare = cleaned(&light, &least, None);
        let steps = regions::steps(broad, self.cells(0.008));
        // Panels of one wall are white together.
        let share = gaussian(
            &Raster::by_rows(width, height, |x, y| {
                [bare.at(x, y) & white.at(x, y), bare.at(x, y)].map(f32::from)
            }),
            self.cells(TOGETHER),
        );
        let pieces = regions::connected(&bare);
        let count = pieces.as_slice().iter().max().map_or(0, |most| *most as usize + 1);
        let mut surfaces = vec![Surface::default(); count];
        let mut rims = Raster::new(width, height, [0.0f32; 2]);
        for y in 0..height {
            for x in 0..width {
                if bare.at(x, y) == 0 || self.distance.at(x, y) >= 0.0 {
                    continue;
                }
                let surface = &mut surfaces[pieces.at(x, y) as usize];
                surface.cells += 1;
                let [of_white, of_light] = share.at(x, y);
                surface.white += f64::from(of_white / of_light.max(1e-6));
                let around = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
                let beyond = |&(x, y): &(usize, usize)| x < width && y < height && bare.at(x, y) == 0;
                if around.iter().any(beyond) {
                    let is_light = |&(x, y): &(usize, usize)| self.photo.at(x, y)[0] > LIGHT_BEYOND;
                    surface.cut += u32::from(around.iter().filter(|at| beyond(at)).any(is_light));
                    let is_soft = steps.at(x, y) < 16.0;
                    surface.rim += 1;
                    surface.soft += u32::from(is_soft);
                    rims.row_mut(y)[x][usize::from(is_soft)] = 1.0;
                }
            }
        }
        let rims = gaussian(&rims, self.cells(ALONG_RIMS));
        bare = Raster::by_rows(width, height, |x, y| {
            // Towards a soft rim only white itself is bare, and what is painted fades into it.
            let [hard, soft] = rims.at(x, y);
            let there =
                bare.at(x, y) != 0 && surfaces[pieces.at(x, y) as usize].is_reserved(self.cells(THIN));
            u8::from(there && (white.at(x, y) != 0 || soft <= hard))
        });
        let slivers = self.slivers(&steps);
        bare.as_mut_slice().iter_mut().zip(slivers.as_slice()).for_each(|(bare, sliver)| *bare |= sliver);
        if let Some(reserve) = reserve {
            let reserve = self.mount.place(&reserve.map(|value| [value]));
            let cells = bare.as_mut_slice().iter_mut().zip(reserve.as_slice());
            cells.for_each(|(bare, [reserve])| *bare |= u8::from(*reserve >= 0.5));
        }
        bare
    }

    /// Slivers of paper left between shapes, few, where edges are hard and light and nothing is exact.
    fn slivers(&self, steps: &Plane) -> Raster<u8> {
        let [width, height] = self.mount.size;
        let much = self.params.slivers as f32;
        if much <= 0.0 {
            return Raster::new(width, height, 0);
        }
        let finding = Finding {
            scale: 196.0,
            least_cells: self.area(8e-4) as usize,
            rounding: self.cells(0.004),
            least_step: 26.0,
        };
        let (_, edges) = voted(&regions(&self.abstractions[1], steps, &finding), self.cells(0.002));
        let chance = plane(self.seed, "slivers", self.mount.size, self.cells(0.03));
        let light = gaussian(&self.abstractions[1], self.cells(0.004));
        let loose = gaussian_plane(&self.exact, self.cells(0.01));
        let reach = self.cells(0.0022) as f32 * much;
        let there = Raster::by_rows(width, height, |x, y| {
            let chance = (chance.at(x, y) - 0.9).clamp(0.0, 1.2);
            let loose = smoothstep(-loose.at(x, y), -0.4, -0.08);
            let is_light = light.at(x, y)[0] > 45.0 && self.distance.at(x, y) < -self.cells(0.02) as f32;
            u8::from(is_light && edges.at(x, y) < reach * chance * loose * self.sharp.at(x, y))
        });
        // What is a cell wide would be a row of dots.
        let round = gaussian_plane(&there.map(f32::from), 1.0);
        let there = Raster::by_rows(width, height, |x, y| u8::from(round.at(x, y) > 0.5) & there.at(x, y));
        let area = self.area(6e-5) as f32;
        cleaned(&there, &Raster::new(width, height, area), None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_piece_of_a_thin_white_is_painted_and_a_whole_or_broad_one_stays_bare() {
        let whole = Surface { cells: 60, white: 60.0, rim: 40, soft: 0, cut: 0 };
        let broad = Surface { cells: 600, white: 600.0, cut: 4, ..whole };
        assert!(whole.is_reserved(4.0) && broad.is_reserved(4.0));
        assert!(!Surface { cut: 4, ..whole }.is_reserved(4.0));
        assert!(
            !Surface { soft: 20, ..whole }.is_reserved(4.0)
                && !Surface { white: 30.0, ..whole }.is_reserved(4.0)
        );
    }
}
