//! The middle line of a mask, one cell wide, and the branches it consists of.

use girtin_grid::Raster;

/// Middle lines of a mask on a grid with a border of one cell, so that every cell has eight neighbours.
pub(super) struct Skeleton {
    stride: usize,
    there: Vec<bool>,
    /// The cells of the lines, row after row.
    cells: Vec<usize>,
}

/// A part of a skeleton between two places where it ends or forks.
#[derive(Debug)]
pub(super) struct Branch {
    /// Columns and rows of its cells, in order.
    pub cells: Vec<[u32; 2]>,
    /// The fork at which it begins and that at which it ends, where it does not end freely.
    pub forks: [Option<usize>; 2],
}

/// Branches, and how many forks they meet at.
pub(super) struct Branches {
    pub branches: Vec<Branch>,
    pub forks: usize,
}

/// No fork.
const NONE: u32 = u32::MAX;

impl Skeleton {
    /// Thins a mask until only its middle lines are left; what hangs together still does, and ends stay.
    ///
    /// # Source
    /// Guo and Hall, *Parallel Thinning with Two-Subiteration Algorithms*, 1989, A1. It leaves steps two cells thick, of
    /// which one pass takes the corners.
    pub fn of(mask: &Raster<bool>) -> Self {
        let (width, height) = (mask.width(), mask.height());
        let stride = width + 2;
        let mut there = vec![false; stride * (height + 2)];
        for y in 0..height {
            there[(y + 1) * stride + 1..][..width].copy_from_slice(mask.row(y));
        }
        let cells = (0..there.len()).filter(|&cell| there[cell]).collect();
        let mut skeleton = Self { stride, there, cells };
        let tables: [[bool; 256]; 2] =
            [false, true].map(|second| core::array::from_fn(|around| is_outer(around as u8, second)));
        let mut gone = Vec::new();
        loop {
            let before = skeleton.cells.len();
            for table in &tables {
                gone.clear();
                gone.extend(
                    skeleton.cells.iter().copied().filter(|&cell| table[usize::from(skeleton.around(cell))]),
                );
                gone.iter().for_each(|&cell| skeleton.there[cell] = false);
                skeleton.tidy();
            }
            if skeleton.cells.len() == before {
                break;
            }
        }
        for at in 0..skeleton.cells.len() {
            let cell = skeleton.cells[at];
            let around = skeleton.around(cell);
            if around.count_ones() > 1 && parts(around) == 1 {
                skeleton.there[cell] = false;
            }
        }
        skeleton.tidy();
        skeleton
    }

    fn tidy(&mut self) {
        let there = &self.there;
        self.cells.retain(|&cell| there[cell]);
    }

    /// The eight neighbours of a cell, clockwise from the one above.
    fn neighbours(&self, cell: usize) -> [usize; 8] {
        let (above, below) = (cell - self.stride, cell + self.stride);
        [above, above + 1, cell + 1, below + 1, below, below - 1, cell - 1, above - 1]
    }

    /// Which of the neighbours are there, a bit each.
    fn around(&self, cell: usize) -> u8 {
        let bit = |(k, at): (usize, usize)| u8::from(self.there[at]) << k;
        self.neighbours(cell).into_iter().enumerate().map(bit).sum()
    }

    /// Cuts the lines at their forks. A fork is all cells with three neighbours or more that touch each other.
    pub fn branches(&self) -> Branches {
        let mut fork_of = vec![NONE; self.there.len()];
        let is_fork = |cell: usize| self.around(cell).count_ones() > 2;
        let mut forks = 0;
        let mut open = Vec::new();
        for &cell in &self.cells {
            if fork_of[cell] != NONE || !is_fork(cell) {
                continue;
            }
            fork_of[cell] = forks;
            open.push(cell);
            while let Some(cell) = open.pop() {
                for next in self.neighbours(cell) {
                    if self.there[next] && fork_of[next] == NONE && is_fork(next) {
                        fork_of[next] = forks;
                        open.push(next);
                    }
                }
            }
            forks += 1;
        }
        let mut free = self.there.clone();
        self.cells.iter().filter(|&&cell| fork_of[cell] != NONE).for_each(|&cell| free[cell] = false);
        let mut branches = Vec::new();
        // First those with ends, then rings, which have none.
        for rings in [false, true] {
            for &cell in &self.cells {
                let ways = self.neighbours(cell).into_iter().filter(|&next| free[next]).count();
                if free[cell] && (rings || ways < 2) {
                    branches.push(self.walked(cell, &mut free, &fork_of));
                }
            }
        }
        Branches { branches, forks: forks as usize }
    }

    fn walked(&self, first: usize, free: &mut [bool], fork_of: &[u32]) -> Branch {
        let mut path = vec![first];
        free[first] = false;
        let mut last = first;
        while let Some(next) = self.neighbours(last).into_iter().find(|&next| free[next]) {
            free[next] = false;
            path.push(next);
            last = next;
        }
        let forks_at = |cell: usize| {
            self.neighbours(cell).into_iter().filter(|&next| fork_of[next] != NONE).map(|next| fork_of[next])
        };
        let begin = forks_at(first).next();
        // A single cell between two forks ends at the other one.
        let end = if path.len() > 1 {
            forks_at(last).next()
        } else {
            forks_at(last).find(|&fork| Some(fork) != begin)
        };
        let place = |cell: &usize| [(cell % self.stride - 1) as u32, (cell / self.stride - 1) as u32];
        Branch {
            cells: path.iter().map(place).collect(),
            forks: [begin, end].map(|fork| fork.map(|fork| fork as usize)),
        }
    }
}

/// In how many parts the neighbours of a cell would fall without it.
fn parts(around: u8) -> u32 {
    let p = |k: u32| around >> (k % 8) & 1;
    (0..8).step_by(2).map(|k| u32::from((1 - p(k)) & (p(k + 1) | p(k + 2)))).sum()
}

/// Whether a cell with these neighbours is taken away, in the first or the second of two passes.
fn is_outer(around: u8, second: bool) -> bool {
    let p = |k: u32| around >> (k % 8) & 1;
    let pairs = |from: u32| (0..4).map(|k| p(from + 2 * k) | p(from + 2 * k + 1)).sum::<u8>();
    let few = pairs(0).min(pairs(7));
    let side = if second { (p(0) | p(1) | (1 - p(3))) & p(2) } else { (p(4) | p(5) | (1 - p(7))) & p(6) };
    parts(around) == 1 && (2..=3).contains(&few) && side == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn branches(width: usize, height: usize, mask: impl Fn(usize, usize) -> bool) -> Branches {
        Skeleton::of(&Raster::from_fn(width, height, mask)).branches()
    }

    #[test]
    fn a_bar_is_one_branch_along_its_middle() {
        let found = branches(40, 11, |x, y| (5..35).contains(&x) && (3..8).contains(&y));
        assert_eq!((found.branches.len(), found.forks), (1, 0));
        let branch = &found.branches[0];
        assert!(branch.cells.len() > 22, "{}", branch.cells.len());
        assert!(branch.cells.iter().all(|cell| cell[1] == 5), "{:?}", branch.cells);
    }

    #[test]
    fn a_ring_has_no_end_and_a_plus_has_four() {
        let ring = branches(30, 30, |x, y| {
            let (dx, dy) = (x as f32 - 15.0, y as f32 - 15.0);
            (8.0..11.0).contains(&(dx * dx + dy * dy).sqrt())
        });
        assert_eq!((ring.branches.len(), ring.forks), (1, 0));
        let plus = branches(41, 41, |x, y| x.abs_diff(20) < 2 || y.abs_diff(20) < 2);
        assert_eq!((plus.branches.len(), plus.forks), (4, 1));
        assert!(plus.branches.iter().all(|branch| branch.forks.iter().flatten().count() == 1));
    }

    #[test]
    fn masks_up_to_the_border_are_fine() {
        assert_eq!(branches(0, 0, |_, _| true).branches.len(), 0);
        assert_eq!(branches(1, 1, |_, _| true).branches.len(), 1);
        assert_eq!(branches(20, 3, |_, _| true).branches.len(), 1);
    }
}
