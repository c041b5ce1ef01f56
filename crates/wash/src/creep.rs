//! Creep: a film that stands high enough wets the paper beside it. One rule from dry paper to wet.
//!
//! Only the edge of the wet paper is looked at, and everything is decided by the state before, so no order matters and
//! a mirrored wash creeps mirrored.

use girtin_grid::{Field, Layout};

use crate::region::Region;

/// What holds an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Film that creeps over full pores.
    pub wetting: f32,
    /// How much more it takes over dry paper.
    pub pinning: f32,
    /// How much more peaks hold than valleys.
    pub roughness: f32,
    /// Share of its film that a cell gives to one that it wets.
    pub share: f32,
    /// Capacity of the deepest valley.
    pub capacity: f32,
    /// How much more the highest peak has.
    pub capacity_range: f32,
}

impl Edge {
    /// The film that wets dry paper of this height whose pores are so full.
    pub fn need(&self, height: f32, fill: f32) -> f32 {
        let dryness = if fill < 1.0 { 1.0 - fill } else { 0.0 };
        self.wetting + self.pinning * dryness * (1.0 + self.roughness * (2.0 * height - 1.0))
    }
}

/// The fields that decide.
#[derive(Clone, Copy, Debug)]
pub struct Sheet<'a> {
    /// Wet mask.
    pub mask: &'a Field<u8>,
    /// Film.
    pub film: &'a Field<f32>,
    /// Pore water.
    pub saturation: &'a Field<f32>,
    /// Paper height.
    pub height: &'a Field<f32>,
}

/// A cell whose film changes: field row, field column, its film afterwards, and whether it becomes wet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crept {
    /// Field row.
    pub row: usize,
    /// Field column.
    pub x: usize,
    /// Its film.
    pub film: f32,
    /// Whether it was dry.
    pub joins: bool,
}

/// Neighbours of a cell: above, before, after, below.
fn around(row: usize, x: usize) -> [(usize, usize); 4] {
    [(row - 1, x), (row, x - 1), (row, x + 1), (row + 1, x)]
}

impl Sheet<'_> {
    fn is_wet(&self, (row, x): (usize, usize)) -> bool {
        self.mask.row(row)[x] != 0
    }

    fn is_dry_paper(&self, (row, x): (usize, usize)) -> bool {
        let layout = self.mask.layout();
        layout.rows().contains(&row) && layout.columns().contains(&x) && !self.is_wet((row, x))
    }

    fn film(&self, (row, x): (usize, usize)) -> f32 {
        self.film.row(row)[x]
    }

    /// The film that wets a dry cell.
    fn need(&self, edge: &Edge, (row, x): (usize, usize)) -> f32 {
        let height = self.height.row(row)[x];
        let fill = self.saturation.row(row)[x] / (height * edge.capacity_range + edge.capacity);
        edge.need(height, fill)
    }

    /// Whether the film of `from` wets the dry cell `to`.
    fn wets(&self, edge: &Edge, from: (usize, usize), to: (usize, usize)) -> bool {
        self.is_wet(from) && self.is_dry_paper(to) && self.film(from) > self.need(edge, to)
    }

    /// How many wet cells would wet this dry one.
    fn donors(&self, edge: &Edge, to: (usize, usize)) -> u32 {
        around(to.0, to.1).map(|from| u32::from(self.wets(edge, from, to))).iter().sum()
    }

    /// What this wet cell offers to each of the dry ones it would wet.
    fn offer(&self, edge: &Edge, from: (usize, usize)) -> f32 {
        let takers: u32 = around(from.0, from.1).map(|to| u32::from(self.wets(edge, from, to))).iter().sum();
        if takers == 0 {
            return 0.0;
        }
        let kept = (0..takers).fold(1.0, |kept, _| kept * (1.0 - edge.share));
        self.film(from) * ((1.0 - kept) / takers as f32)
    }

    /// What flows from a wet cell into a dry one.
    fn flow(&self, edge: &Edge, from: (usize, usize), to: (usize, usize)) -> f32 {
        if self.wets(edge, from, to) {
            self.offer(edge, from) * (1.0 / self.donors(edge, to) as f32)
        } else {
            0.0
        }
    }

    /// Appends what changes in one row and in its neighbours on account of the dry cells of this row.
    ///
    /// A cell may be named by several rows, each time with the same film.
    ///
    /// # Guarantees
    /// What is given is what is taken, to rounding; no film goes below 0.
    pub fn creep_row(&self, edge: &Edge, region: &Region, row: usize, crept: &mut Vec<Crept>) {
        let canvas = self.mask.layout().columns();
        // Dry cells beside a wet one lie within one cell of the runs of three rows.
        let runs = (row - 1..=row + 1).flat_map(|row| region.runs(row));
        let (mut first, mut end) = (usize::MAX, 0);
        for run in runs {
            (first, end) = (first.min(run.first - 1), end.max(run.end + 1));
        }
        let (first, end) = (first.max(canvas.start), end.min(canvas.end));
        if first >= end {
            return;
        }
        let [above, here, below] = [row - 1, row, row + 1].map(|row| self.mask.row(row));
        let is_edge = |x: usize| here[x] == 0 && (above[x] | below[x] | here[x - 1] | here[x + 1]) != 0;
        // No cell of a run that is wet throughout is dry.
        let wet_runs = || region.runs(row).iter().filter(|run| run.all_wet);
        let starts = std::iter::once(first).chain(wet_runs().map(|run| run.end));
        let ends = wet_runs().map(|run| run.first).chain(std::iter::once(end));
        let gaps = starts.zip(ends).flat_map(|(start, end)| start..end);
        for x in gaps.filter(|&x| is_edge(x)) {
            let to = (row, x);
            if self.donors(edge, to) == 0 {
                continue;
            }
            let [up, left, right, down] = around(row, x).map(|from| self.flow(edge, from, to));
            crept.push(Crept { row, x, film: self.film(to) + ((up + down) + (left + right)), joins: true });
            for from in around(row, x).into_iter().filter(|&from| self.wets(edge, from, to)) {
                let [up, left, right, down] = around(from.0, from.1).map(|to| self.flow(edge, from, to));
                let film = self.film(from) - ((up + down) + (left + right));
                let film = if film > 0.0 { film } else { 0.0 };
                crept.push(Crept { row: from.0, x: from.1, film, joins: false });
            }
        }
    }
}

/// The rows that may have an edge.
pub fn edge_rows(region: &Region, layout: Layout) -> std::ops::Range<usize> {
    let active = region.active();
    if active.is_empty() {
        return active;
    }
    (active.start - 1).max(layout.rows().start)..(active.end + 1).min(layout.rows().end)
}
