//! A palette for a picture: a few real pigments that can mix its colors, chosen with a painter's taste.

use girtin_grid::{Raster, random};
use girtin_optics::pigment::Character;
use girtin_optics::{Lab, LinearRgb, Pigment};
use rayon::prelude::*;

use crate::separate::{Limits, MOST, Paints, lab};

/// Colors that stand for a picture.
const CLUSTERS: usize = 22;
/// Palettes that are followed at a time.
const BEAM: usize = 4;
/// Gain, CIEDE2000, below which a further pigment is not worth its place.
const WORTH: f64 = 0.1;

/// Difference, CIEDE2000, that counts twice: one color gone wrong is seen where many that are hardly off are not.
const SEEN: f64 = 10.0;

/// A color of the picture and how much it counts.
pub type Cluster = ([f32; 3], f64);

/// The colors that stand for a Lab picture, by k-means.
pub fn clusters(lab: &Raster<[f32; 3]>, seed: u64) -> Vec<Cluster> {
    let step = (lab.as_slice().len() / 6000).max(1);
    let colors: Vec<[f32; 3]> = lab.as_slice().iter().copied().step_by(step).collect();
    let distance = |a: &[f32; 3], b: &[f32; 3]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f32>();
    let key = random::key(seed, random::stage("palette clusters"));
    let Some(&first) = colors.first() else { return Vec::new() };
    let mut centers = vec![first];
    let mut far: Vec<f32> = colors.iter().map(|color| distance(color, &first)).collect();
    while centers.len() < CLUSTERS {
        let sum: f64 = far.iter().map(|far| f64::from(*far)).sum();
        if sum < 1.0 {
            break;
        }
        let mut left = random::unit_f64(random::at(key, [centers.len() as i64, 0])) * sum;
        let next = far.iter().position(|far| {
            left -= f64::from(*far);
            left <= 0.0
        });
        let next = colors[next.unwrap_or(colors.len() - 1)];
        far.iter_mut().zip(&colors).for_each(|(far, color)| *far = far.min(distance(color, &next)));
        centers.push(next);
    }
    let mut counts = vec![0usize; centers.len()];
    for _ in 0..12 {
        let mut sums = vec![([0.0f64; 3], 0usize); centers.len()];
        for color in &colors {
            let nearest = (0..centers.len())
                .min_by(|&a, &b| distance(color, &centers[a]).total_cmp(&distance(color, &centers[b])))
                .unwrap_or(0);
            sums[nearest].1 += 1;
            sums[nearest].0.iter_mut().zip(color).for_each(|(sum, value)| *sum += f64::from(*value));
        }
        for (k, (sum, count)) in sums.iter().enumerate().filter(|(_, (_, count))| *count > 0) {
            centers[k] = sum.map(|sum| (sum / *count as f64) as f32);
        }
        counts = sums.iter().map(|(_, count)| *count).collect();
    }
    // Small colors count for more than their area: a red roof in a green wood needs its red.
    let weights: Vec<f64> = counts.iter().map(|&count| libm::sqrt(count as f64)).collect();
    let sum: f64 = weights.iter().sum();
    centers.into_iter().zip(weights.into_iter().map(|weight| weight / sum.max(1e-9))).collect()
}

/// What a painter says against a pigment, CIEDE2000.
fn distaste(pigment: &Pigment) -> f64 {
    let says = |character: Character| pigment.character.contains(&character);
    let of = |character, dear: f64| if says(character) { dear } else { 0.0 };
    // Opaque paint kills the paper's light, and mixtures are the palette's own business; washes that granulate or lift are
    // watercolor's charm, strong stains are its peril.
    of(Character::Opaque, 1.2)
        + of(Character::SemiOpaque, 0.35)
        + of(Character::SemiTransparent, 0.05)
        + of(Character::Mixed, 0.25)
        + of(Character::StrongTinting, 0.12)
        + of(Character::WeakTinting, 0.25)
        - of(Character::Granulating, 0.08)
        - of(Character::Lifting, 0.04)
}

/// Whether a palette has a yellow, a red and a blue, as far as the picture has color at all.
fn imbalance(pigments: &[&Pigment], colorful: f64) -> f64 {
    let hue = |pigment: &Pigment| {
        let ground = [LinearRgb::WHITE.0[0] as f32; 3];
        let [_, a, b] = lab(Paints::new([&pigment.coefficients]).over(&[0.6], ground));
        (libm::atan2f(b, a).to_degrees().rem_euclid(360.0), libm::hypotf(a, b))
    };
    let has = |low: f32, high: f32| {
        pigments.iter().any(|pigment| {
            let (hue, chroma) = hue(pigment);
            chroma > 18.0 && (low..high).contains(&hue)
        })
    };
    let is_missing = |there: bool| if there { 0.0 } else { 0.45 * colorful };
    is_missing(has(55.0, 112.0))
        + is_missing(has(0.0, 55.0) || has(335.0, 360.0))
        + is_missing(has(210.0, 310.0))
}

/// Chooses up to `most` of the pigments for a picture's colors over paper; the order is the stock's.
///
/// A beam search: palettes grow by a pigment at a time, the best few are followed, until a further pigment gains little.
pub fn choose<'a>(
    stock: impl IntoIterator<Item = &'a Pigment>,
    clusters: &[Cluster],
    paper: [f32; 3],
    most: usize,
) -> Vec<&'a Pigment> {
    let usable = |pigment: &&Pigment| {
        // White is the paper, and paint that shimmers depends on the light.
        !pigment.character.contains(&Character::Interference) && !pigment.id.ends_with("-white")
    };
    let stock: Vec<&Pigment> = stock.into_iter().filter(usable).collect();
    let limits = Limits { each: 2.0, total: 3.0, thrift: 0.5, keeping: 0.0, rounds: 9, hue: 1.0 };
    let colorful = clusters.iter().map(|([_, a, b], weight)| f64::from(libm::hypotf(*a, *b)) * weight);
    let colorful = (colorful.sum::<f64>() / 15.0).min(1.0);
    let score = |palette: &Vec<usize>| {
        let pigments: Vec<&Pigment> = palette.iter().map(|&at| stock[at]).collect();
        let paints = Paints::new(pigments.iter().map(|pigment| &pigment.coefficients));
        let error: f64 = clusters
            .iter()
            .map(|(wanted, weight)| {
                let (_, error) = paints.separate(*wanted, paper, None, &limits);
                let found = [0, 1, 2].map(|c: usize| wanted[c] + error[c]);
                let off = as_lab(found).ciede2000(as_lab(*wanted));
                weight * off * (1.0 + off / SEEN)
            })
            .sum();
        let taste: f64 = pigments.iter().map(|pigment| distaste(pigment)).sum();
        error + 0.5 * taste + imbalance(&pigments, colorful)
    };
    let mut beam: Vec<(Vec<usize>, f64)> = vec![(Vec::new(), f64::INFINITY)];
    let mut best: (Vec<usize>, f64) = (Vec::new(), f64::INFINITY);
    for size in 1..=most.min(MOST) {
        let mut candidates: Vec<Vec<usize>> = Vec::new();
        for (palette, _) in &beam {
            for at in (0..stock.len()).filter(|at| !palette.contains(at)) {
                let mut longer = palette.clone();
                longer.push(at);
                longer.sort_unstable();
                candidates.push(longer);
            }
        }
        candidates.sort();
        candidates.dedup();
        let scores: Vec<f64> = candidates.par_iter().map(score).collect();
        beam = candidates.into_iter().zip(scores).collect();
        beam.sort_by(|a, b| a.1.total_cmp(&b.1).then_with(|| a.0.cmp(&b.0)));
        beam.truncate(BEAM);
        let Some(first) = beam.first() else { break };
        let gained = best.1 - first.1;
        if gained < WORTH && size > 3 {
            break;
        }
        if gained > 0.0 {
            best = first.clone();
        }
    }
    best.0.into_iter().map(|at| stock[at]).collect()
}

fn as_lab([l, a, b]: [f32; 3]) -> Lab {
    Lab { l: f64::from(l), a: f64::from(a), b: f64::from(b) }
}
