//! A closed path becomes a matte.

use girtin_grid::Raster;

/// Lines that a row of pixels is filled by.
const LINES: usize = 8;

/// How much of each pixel lies inside a closed path through pixels' centers, by the even-odd rule.
///
/// # Shapes and units
/// `path`: pixels, the last one joined to the first. Pixels on the path are about half inside.
///
/// # Guarantees
/// The sum is the polygon's area to a tenth of its length (`a_matte_has_the_area_of_its_outline`).
pub fn matte(path: &[[usize; 2]], width: usize, height: usize) -> Raster<f32> {
    let mut matte = Raster::new(width, height, 0.0f32);
    let center = |[x, y]: [usize; 2]| [x as f64 + 0.5, y as f64 + 0.5];
    // Edges by the first line that they meet, so that a line looks at its own edges only.
    let lines = height * LINES;
    let middle = |line: usize| (line as f64 + 0.5) / LINES as f64;
    let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); lines];
    for (at, &from) in path.iter().enumerate() {
        let (from, to) = (center(from), center(path[(at + 1) % path.len()]));
        let (low, high) = (from[1].min(to[1]), from[1].max(to[1]));
        let first = ((low * LINES as f64 - 0.5).ceil().max(0.0) as usize).min(lines);
        for (line, crossings) in crossings.iter_mut().enumerate().skip(first) {
            let y = middle(line);
            if y >= high {
                break;
            }
            crossings.push(from[0] + (y - from[1]) / (to[1] - from[1]) * (to[0] - from[0]));
        }
    }
    for (line, crossings) in crossings.iter_mut().enumerate() {
        crossings.sort_by(f64::total_cmp);
        for pair in crossings.chunks_exact(2) {
            fill(matte.row_mut(line / LINES), pair[0], pair[1]);
        }
    }
    matte.map(|covered| covered.clamp(0.0, 1.0))
}

/// Adds a line from one column to another.
fn fill(row: &mut [f32], from: f64, to: f64) {
    let width = row.len() as f64;
    let (from, to) = (from.clamp(0.0, width), to.clamp(0.0, width));
    let first = from as usize;
    let end = (to.ceil() as usize).min(row.len());
    for (x, covered) in row.iter_mut().enumerate().take(end).skip(first) {
        let part = to.min(x as f64 + 1.0) - from.max(x as f64);
        *covered += (part / LINES as f64) as f32;
    }
}
