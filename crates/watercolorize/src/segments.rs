//! Cells gathered into small segments of like color.

use girtin_grid::Raster;
use rayon::prelude::*;

/// Steps of color that are told apart, and how many of them are one Lab unit.
const LEVELS: usize = 1 << 13;
const PER_UNIT: f32 = 64.0;

/// The neighbours after a cell: to the right, below left, below, below right.
const AFTER: [(isize, usize); 4] = [(1, 0), (-1, 1), (0, 1), (1, 1)];

/// Cells of a Lab picture joined where they differ less than inside of what is joined already, numbered from 0 in the order
/// of their first cells.
///
/// `scale` is how large segments like to be, Lab × cells; none has fewer than `least` cells, unless the picture has.
///
/// # Source
/// Felzenszwalb and Huttenlocher, *Efficient Graph-Based Image Segmentation*, 2004, on eight neighbours.
pub(crate) fn segments(lab: &Raster<[f32; 3]>, scale: f32, least: usize) -> Raster<u32> {
    let (width, height) = (lab.width(), lab.height());
    let pairs = sorted_pairs(lab);
    let ends = |pair: u32| {
        let (cell, (dx, dy)) = ((pair / 4) as usize, AFTER[(pair % 4) as usize]);
        (cell as u32, (cell + dy * width).wrapping_add_signed(dx) as u32)
    };
    let mut sets = Sets::new(width * height);
    // How much a set allows: its largest inner step, and more while it is small.
    let mut allowed = vec![scale; width * height];
    let mut left = Vec::new();
    for &(pair, level) in &pairs {
        let (a, b) = ends(pair);
        let (a, b) = (sets.of(a), sets.of(b));
        if a == b {
            continue;
        }
        let step = f32::from(level) / PER_UNIT;
        if step <= allowed[a as usize].min(allowed[b as usize]) {
            let joined = sets.join(a, b) as usize;
            allowed[joined] = step + scale / sets.size[joined] as f32;
        } else {
            left.push(pair);
        }
    }
    for pair in left {
        let (a, b) = ends(pair);
        let (a, b) = (sets.of(a), sets.of(b));
        if a != b && (sets.size[a as usize].min(sets.size[b as usize]) as usize) < least {
            sets.join(a, b);
        }
    }
    sets.numbered(width, height)
}

/// All pairs of neighbours, by the step between them; a pair is a cell times four and its direction.
fn sorted_pairs(lab: &Raster<[f32; 3]>) -> Vec<(u32, u16)> {
    let (width, height) = (lab.width(), lab.height());
    const NONE: u16 = u16::MAX;
    let levels: Vec<[u16; 4]> = (0..width * height)
        .into_par_iter()
        .with_min_len(width.max(1))
        .map(|cell| {
            let (x, y) = (cell % width, cell / width);
            let own = lab.as_slice()[cell];
            AFTER.map(|(dx, dy)| {
                let (x, y) = (x.wrapping_add_signed(dx), y + dy);
                if x >= width || y >= height {
                    return NONE;
                }
                let other = lab.as_slice()[y * width + x];
                let square: f32 = own.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum();
                ((square.sqrt() * PER_UNIT) as usize).min(LEVELS - 1) as u16
            })
        })
        .collect();
    let mut starts = vec![0u32; LEVELS + 1];
    let there = || levels.as_flattened().iter().enumerate().filter(|(_, level)| **level != NONE);
    there().for_each(|(_, &level)| starts[level as usize + 1] += 1);
    for level in 0..LEVELS {
        starts[level + 1] += starts[level];
    }
    let mut pairs = vec![(0u32, 0u16); starts[LEVELS] as usize];
    for (pair, &level) in there() {
        let start = &mut starts[level as usize];
        pairs[*start as usize] = (pair as u32, level);
        *start += 1;
    }
    pairs
}

/// Sets of things that grow together.
pub(crate) struct Sets {
    parent: Vec<u32>,
    size: Vec<u32>,
}

impl Sets {
    /// So many sets of one each.
    pub(crate) fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect(), size: vec![1; count] }
    }

    /// The set that something is in.
    pub(crate) fn of(&mut self, mut at: u32) -> u32 {
        while self.parent[at as usize] != at {
            let above = self.parent[self.parent[at as usize] as usize];
            self.parent[at as usize] = above;
            at = above;
        }
        at
    }

    /// Joins two sets; returns the set they are.
    pub(crate) fn join(&mut self, a: u32, b: u32) -> u32 {
        let (large, small) = if self.size[a as usize] >= self.size[b as usize] { (a, b) } else { (b, a) };
        self.parent[small as usize] = large;
        self.size[large as usize] += self.size[small as usize];
        large
    }

    /// The sets of a raster's cells, numbered from 0 in the order of their first cells.
    pub(crate) fn numbered(mut self, width: usize, height: usize) -> Raster<u32> {
        let mut numbers = vec![u32::MAX; self.parent.len()];
        let mut count = 0;
        Raster::from_fn(width, height, |x, y| {
            let set = self.of((y * width + x) as u32) as usize;
            if numbers[set] == u32::MAX {
                numbers[set] = count;
                count += 1;
            }
            numbers[set]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_parts_are_segments_and_specks_are_not() {
        let lab = Raster::from_fn(40, 30, |x, y| match (x, y) {
            (5, 5) => [90.0, 0.0, 0.0],
            (0..20, _) => [30.0, 0.0, 0.0],
            _ => [60.0, 10.0, 0.0],
        });
        let found = segments(&lab, 5.0, 4);
        assert_eq!(found, Raster::from_fn(40, 30, |x, _| u32::from(x >= 20)));
    }

    #[test]
    fn any_size_has_segments() {
        for (width, height) in [(1, 1), (1, 9), (9, 1), (0, 0)] {
            let found = segments(&Raster::new(width, height, [50.0, 0.0, 0.0]), 3.0, 10);
            assert!(found.as_slice().iter().all(|&segment| segment == 0));
        }
    }
}
