//! `FlowOutward`: water is drawn toward the edge of the wash, and pigment with it; the edge dries darker.

use std::ops::Range;

use girtin_grid::blur::gaussian_weights;
use girtin_grid::{Field, Layout};
use multiversion::multiversion;
use rayon::prelude::*;

use crate::engine::ground::Ground;
use crate::region::{VECTOR, first_where};

/// Takes water from the cells of one row.
///
/// # Source
/// Curtis et al. 1997, §4.3.3, `FlowOutward`: p ← p − η(1 − M′)M.
///
/// # Shapes and units
/// Field rows cut to the columns where `outflow` is not all 0; `outflow` is η(1 − M′)M.
pub fn draw_off(pressure: &mut [f32], outflow: &[f32]) {
    draw_off_kernel(pressure, outflow);
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn draw_off_kernel(pressure: &mut [f32], outflow: &[f32]) {
    let n = pressure.len();
    let outflow = &outflow[..n];
    for i in 0..n {
        pressure[i] -= outflow[i];
    }
}

/// η(1 − M′)M of the whole canvas, kept from step to step and renewed only where the wet mask changed.
///
/// 1 − M′ is computed as the blur of 1 − M, so that it is exactly 0 where the blur sees wet paper only, whatever the
/// order in which it was computed.
///
/// # Deviations
/// D5, D6.
#[derive(Clone, Debug)]
pub struct Outflow {
    edge_darkening: f32,
    /// Gaussian weights from the middle outward.
    half_weights: Vec<f32>,
    amount: Field<f32>,
    /// Per row, the columns where the amount is not 0.
    spans: Vec<Vec<Range<usize>>>,
    /// The same as places in a field, widened to whole vectors, and where the amount of each begins.
    places: Vec<Vec<(Range<usize>, usize)>>,
}

impl Outflow {
    /// An outflow of 0 everywhere; `edge_kernel` is K, cells.
    pub fn new(layout: Layout, edge_darkening: f64, edge_kernel: f64) -> Self {
        let radius = (edge_kernel / 2.0) as usize;
        let weights = gaussian_weights(edge_kernel / 4.0, radius); // D6
        Self {
            edge_darkening: edge_darkening as f32,
            half_weights: weights[radius..].to_vec(),
            amount: Field::<f32>::zeroed(layout),
            spans: vec![Vec::new(); layout.rows().end],
            places: vec![Vec::new(); layout.rows().end],
        }
    }

    /// The amounts of one row.
    pub fn row(&self, row: usize) -> &[f32] {
        self.amount.row(row)
    }

    /// How far it sees, cells.
    pub fn radius(&self) -> usize {
        self.half_weights.len() - 1
    }

    /// The columns of one row where the amount is not 0.
    pub fn spans(&self, row: usize) -> &[Range<usize>] {
        &self.spans[row]
    }

    /// The amounts of one row that are not 0, with their places in a field.
    pub fn amounts(&self, row: usize) -> impl Iterator<Item = (usize, &[f32])> {
        let amounts = self.amount.values();
        self.places[row].iter().map(|(place, start)| (place.start, &amounts[*start..][..place.len()]))
    }

    /// The same for packed fields, with nothing between the amounts; they cannot be renewed.
    pub fn packed(mut self, ground: &Ground) -> Self {
        let all = || {
            self.spans.iter().enumerate().flat_map(|(row, spans)| spans.iter().map(move |span| (row, span)))
        };
        let total = all().map(|(_, span)| span.len().next_multiple_of(VECTOR)).sum();
        let mut amount = Field::<f32>::zeroed(Layout::new(total, 1));
        let mut places = vec![Vec::new(); self.spans.len()];
        let mut start = amount.layout().stride() + Layout::LEFT;
        for (row, span) in all() {
            let columns = span.start..span.start + span.len().next_multiple_of(VECTOR);
            let place = ground.place(row, columns.start);
            places[row].push((place..place + columns.len(), start));
            amount.values_mut()[start..][..columns.len()]
                .copy_from_slice(&self.amount.row(row)[columns.clone()]);
            start += columns.len();
        }
        (self.amount, self.places) = (amount, places);
        self
    }

    /// Blurs again whatever a change of the mask inside a rectangle of field rows and columns reaches.
    ///
    /// `bands` of rows are worked on at a time; their number changes no bit of the result.
    pub fn renew(&mut self, edge: Edge<'_>, rows: Range<usize>, columns: Range<usize>, bands: usize) {
        let mask = edge.mask;
        let layout = mask.layout();
        let radius = self.radius();
        let widen = |range: Range<usize>, limit: Range<usize>| {
            range.start.saturating_sub(radius).max(limit.start)..(range.end + radius).min(limit.end)
        };
        let (rows, columns) = (widen(rows, layout.rows()), widen(columns, layout.columns()));
        if rows.is_empty() || columns.is_empty() || self.edge_darkening == 0.0 {
            return;
        }
        let cuts: Vec<usize> = (0..=bands).map(|band| rows.start + rows.len() * band / bands).collect();
        let (weights, strength) = (&self.half_weights, self.edge_darkening);
        self.amount.bands_mut(&cuts).into_par_iter().for_each(|mut band| {
            let mut blurred = RowBlurs::new(edge, columns.clone(), weights);
            let mut dryness = vec![0.0; columns.len()];
            for row in band.rows() {
                let wet = &mask.row(row)[columns.clone()];
                let out = &mut band.row_mut(row)[columns.clone()];
                if wet.iter().all(|&cell| cell == 0) {
                    // Written only where needed: dry pages stay untouched.
                    out.iter_mut().filter(|amount| **amount != 0.0).for_each(|amount| *amount = 0.0);
                    continue;
                }
                dryness.fill(0.0);
                add_scaled_pair(&mut dryness, blurred.row(row as isize), None, weights[0]);
                for (tap, &weight) in weights.iter().enumerate().skip(1) {
                    let (above, below) =
                        blurred.rows(row as isize - tap as isize, row as isize + tap as isize);
                    add_scaled_pair(&mut dryness, above, Some(below), weight);
                }
                put_amounts(out, &dryness, wet, strength);
            }
        });
        for row in rows {
            self.spans[row] = nonzero_spans(self.amount.row(row), layout.columns());
            let start = row * layout.stride();
            let place =
                |columns: Range<usize>| (start + columns.start..start + columns.end, start + columns.start);
            self.places[row] = self.spans[row].iter().map(|span| place(whole_vectors(span))).collect();
        }
    }
}

/// η(1 − M′)M of one row, from its 1 − M′.
#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn put_amounts(amounts: &mut [f32], dryness: &[f32], wet: &[u8], strength: f32) {
    let n = amounts.len();
    let (dryness, wet) = (&dryness[..n], &wet[..n]);
    for i in 0..n {
        let amount = strength * dryness[i];
        amounts[i] = if wet[i] != 0 { amount } else { 0.0 };
    }
}

/// The columns where a row is not 0, short gaps included.
fn nonzero_spans(row: &[f32], columns: Range<usize>) -> Vec<Range<usize>> {
    const WORTH_A_GAP: usize = 16;
    let mut spans: Vec<Range<usize>> = Vec::new();
    let mut x = columns.start;
    loop {
        let start = first_where(row, x..columns.end, |amount| amount != 0.0);
        if start == columns.end {
            return spans;
        }
        let end = first_where(row, start..columns.end, |amount| amount == 0.0);
        match spans.last_mut() {
            Some(last) if start < last.end + WORTH_A_GAP => last.end = end,
            _ => spans.push(start..end),
        }
        x = end;
    }
}

/// Columns widened to whole vectors: nothing is drawn off beside them, and a loop has no single cells at its end.
fn whole_vectors(columns: &Range<usize>) -> Range<usize> {
    columns.start - columns.start % VECTOR..columns.end.next_multiple_of(VECTOR)
}

/// What [`Outflow`] sees as the edge of the wet paper.
#[derive(Clone, Copy, Debug)]
pub struct Edge<'a> {
    /// M: only its cells are drawn from.
    pub mask: &'a Field<u8>,
    /// How far each cell counts as wet, 0 to 1; without it as far as M says.
    pub cover: Option<&'a Field<f32>>,
}

/// Rows of 1 − M, or 1 − cover, blurred sideways, made when first asked for and kept while the window of rows passes.
struct RowBlurs<'a> {
    edge: Edge<'a>,
    columns: Range<usize>,
    half_weights: &'a [f32],
    /// Ring of rows, each with the number of the row it holds.
    ring: Vec<(Option<isize>, Vec<f32>)>,
    dry: Vec<f32>,
}

impl<'a> RowBlurs<'a> {
    fn new(edge: Edge<'a>, columns: Range<usize>, half_weights: &'a [f32]) -> Self {
        let radius = half_weights.len() - 1;
        let dry = vec![1.0; columns.len() + 2 * radius];
        let ring = vec![(None, vec![0.0; columns.len()]); 2 * radius + 1];
        Self { edge, columns, half_weights, ring, dry }
    }

    fn slot(&self, row: isize) -> usize {
        row.rem_euclid(self.ring.len() as isize) as usize
    }

    fn fill(&mut self, row: isize) {
        let slot = self.slot(row);
        if self.ring[slot].0 == Some(row) {
            return;
        }
        let radius = self.half_weights.len() - 1;
        let layout = self.edge.mask.layout();
        // Outside the canvas all is dry (D5).
        self.dry.fill(1.0);
        if let Some(row) = usize::try_from(row).ok().filter(|row| layout.rows().contains(row)) {
            let canvas = layout.columns();
            let first = (self.columns.start + radius).saturating_sub(2 * radius).max(canvas.start);
            let end = (self.columns.end + radius).min(canvas.end);
            let dry = &mut self.dry[first + radius - self.columns.start..][..end - first];
            match self.edge.cover {
                Some(cover) => {
                    let cover = &cover.row(row)[first..end];
                    dry.iter_mut().zip(cover).for_each(|(dry, cover)| *dry = 1.0 - cover);
                }
                None => {
                    let mask = &self.edge.mask.row(row)[first..end];
                    dry.iter_mut().zip(mask).for_each(|(dry, &wet)| *dry = f32::from(u8::from(wet == 0)));
                }
            }
        }
        let (holds, out) = &mut self.ring[slot];
        *holds = Some(row);
        out.fill(0.0);
        let width = out.len();
        add_scaled_pair(out, &self.dry[radius..][..width], None, self.half_weights[0]);
        for (tap, &weight) in self.half_weights.iter().enumerate().skip(1) {
            let (before, after) = (&self.dry[radius - tap..][..width], &self.dry[radius + tap..][..width]);
            add_scaled_pair(out, before, Some(after), weight);
        }
    }

    fn row(&mut self, row: isize) -> &[f32] {
        self.fill(row);
        &self.ring[self.slot(row)].1
    }

    fn rows(&mut self, above: isize, below: isize) -> (&[f32], &[f32]) {
        self.fill(above);
        self.fill(below);
        (&self.ring[self.slot(above)].1, &self.ring[self.slot(below)].1)
    }
}

/// out += weight · (a + b): taps left and right of the middle are added first, so a mirrored mask blurs mirrored.
fn add_scaled_pair(out: &mut [f32], a: &[f32], b: Option<&[f32]>, weight: f32) {
    match b {
        Some(b) => add_scaled_pair_kernel(out, a, b, weight),
        None => {
            for (out, &a) in out.iter_mut().zip(a) {
                *out += weight * a;
            }
        }
    }
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn add_scaled_pair_kernel(out: &mut [f32], a: &[f32], b: &[f32], weight: f32) {
    let n = out.len();
    let (a, b) = (&a[..n], &b[..n]);
    for i in 0..n {
        out[i] += weight * (a[i] + b[i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// D6 written out in f64.
    fn plain(mask: &Field<u8>, edge_darkening: f64, kernel: i64) -> Vec<f64> {
        let (width, height) = (mask.layout().width() as i64, mask.layout().height() as i64);
        let taps: Vec<i64> = (-(kernel / 2)..=kernel / 2).collect();
        let sigma = kernel as f64 / 4.0;
        let weight = |t: i64| libm::exp(-((t * t) as f64) / (2.0 * sigma * sigma));
        let sum: f64 = taps.iter().map(|&t| weight(t)).sum();
        let wet = |x: i64, y: i64| {
            let inside = (0..width).contains(&x) && (0..height).contains(&y);
            if inside { f64::from(mask.cells(y as usize)[x as usize]) } else { 0.0 }
        };
        let mut amounts = Vec::new();
        for y in 0..height {
            for x in 0..width {
                let mut blurred = 0.0;
                for &i in &taps {
                    for &j in &taps {
                        blurred += weight(i) * weight(j) / sum / sum * wet(x + i, y + j);
                    }
                }
                amounts.push(edge_darkening * (1.0 - blurred) * wet(x, y));
            }
        }
        amounts
    }

    fn blob(width: usize, height: usize) -> Field<u8> {
        let mut mask = Field::<u8>::zeroed(Layout::new(width, height));
        for y in 0..height {
            for x in 0..width {
                mask.cells_mut(y)[x] = u8::from((x * 7 + y * 5) % 11 != 0 && x > 2);
            }
        }
        mask
    }

    #[test]
    fn outflow_is_the_paper_s() {
        for (width, height, kernel) in [(40, 31, 10), (9, 7, 5), (1, 1, 10), (33, 2, 1), (5, 40, 60)] {
            let mask = blob(width, height);
            let layout = mask.layout();
            let mut outflow = Outflow::new(layout, 0.05, kernel as f64);
            outflow.renew(Edge { mask: &mask, cover: None }, layout.rows(), layout.columns(), 3);
            let wanted = plain(&mask, 0.05, i64::from(kernel));
            for y in 0..height {
                for x in 0..width {
                    let found = outflow.amount.cells(y)[x];
                    assert!(
                        (f64::from(found) - wanted[y * width + x]).abs() < 5e-8,
                        "{width}×{height} {x},{y}"
                    );
                }
            }
        }
    }

    #[test]
    fn renewing_where_the_mask_changed_equals_blurring_everything() {
        let mut mask = blob(64, 48);
        let layout = mask.layout();
        let mut renewed = Outflow::new(layout, 0.05, 10.0);
        renewed.renew(Edge { mask: &mask, cover: None }, layout.rows(), layout.columns(), 2);
        mask.cells_mut(20)[30..34].fill(0);
        mask.cells_mut(21)[10..33].fill(1);
        renewed.renew(Edge { mask: &mask, cover: None }, 21..23, Layout::LEFT + 10..Layout::LEFT + 34, 5);
        let mut whole = Outflow::new(layout, 0.05, 10.0);
        whole.renew(Edge { mask: &mask, cover: None }, layout.rows(), layout.columns(), 1);
        assert_eq!(renewed.amount, whole.amount);
        assert_eq!(renewed.spans, whole.spans);
    }

    #[test]
    fn deep_inside_a_wash_nothing_is_drawn_off() {
        let mut mask = Field::<u8>::zeroed(Layout::new(40, 40));
        (0..40).for_each(|y| mask.cells_mut(y).fill(1));
        let mut outflow = Outflow::new(mask.layout(), 0.05, 10.0);
        outflow.renew(Edge { mask: &mask, cover: None }, mask.layout().rows(), mask.layout().columns(), 1);
        assert!(outflow.amount.cells(20)[6..34].iter().all(|amount| amount.to_bits() == 0));
        assert!(outflow.amount.cells(20)[0] > 0.0);
    }
}
