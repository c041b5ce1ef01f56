use proptest::prelude::*;

use super::*;
use crate::color::encode_srgb;
use crate::library::Library;

/// K and S of C97's figure 5, in its order, as printed (`the_twelve_come_first_as_printed`).
fn figure_5() -> Vec<Published> {
    Library::builtin().iter().filter_map(|pigment| pigment.published).collect()
}

/// Glazes of mixtures over a ground, and what a plain f64 program in another language, written from the paper's text,
/// sees there.
struct Case {
    ground: [f64; 3],
    /// From the ground up: (number in figure 5, amount); K and S as printed.
    glazes: [[(usize, f64); 3]; 3],
    seen: [f64; 3],
}

#[rustfmt::skip]
const CASES: [Case; 6] = [
    Case { ground: [0.703, 0.422, 0.296], glazes: [[(0, 0.653), (11, 0.515), (3, 0.340)], [(2, 0.567), (9, 1.180), (4, 0.233)], [(6, 0.092), (0, 0.155), (2, 0.074)]], seen: [0.195610277221, 0.116816470655, 0.013244329139] },
    Case { ground: [0.914, 0.466, 0.167], glazes: [[(7, 0.414), (9, 0.765), (6, 0.428)], [(0, 0.431), (3, 0.001), (5, 0.474)], [(11, 0.179), (2, 0.997), (8, 0.179)]], seen: [0.522749885459, 0.343137236969, 0.032807017268] },
    Case { ground: [0.957, 0.05, 0.167], glazes: [[(5, 0.307), (10, 0.874), (0, 0.534)], [(1, 1.162), (7, 0.001), (6, 0.069)], [(6, 0.418), (8, 0.516), (2, 0.897)]], seen: [0.574304097761, 0.287963102269, 0.001952798305] },
    Case { ground: [0.439, 0.733, 0.461], glazes: [[(1, 0.637), (0, 0.283), (11, 0.054)], [(2, 0.260), (8, 0.061), (7, 0.104)], [(8, 0.566), (2, 0.708), (3, 0.425)]], seen: [0.309859062629, 0.327072035754, 0.001363375898] },
    Case { ground: [0.874, 0.798, 0.569], glazes: [[(11, 0.361), (9, 1.003), (3, 0.134)], [(11, 0.605), (2, 0.878), (4, 0.454)], [(9, 0.766), (4, 0.612), (5, 0.423)]], seen: [0.018777562014, 0.098317953250, 0.077911780028] },
    Case { ground: [0.677, 0.931, 0.737], glazes: [[(4, 0.574), (6, 0.522), (5, 0.418)], [(10, 0.257), (2, 0.039), (7, 0.732)], [(9, 0.876), (4, 0.141), (1, 0.803)]], seen: [0.180407640619, 0.111882297803, 0.061710850724] },
];

/// Linear K and S of figure 5 by the same program, with §5.1 as printed.
#[rustfmt::skip]
const LINEAR: [([f64; 3], [f64; 3]); 12] = [
    ([0.491135779894, 2.737193632458, 1.232799748981], [0.004717154985, 0.000410588473, 0.003652402811]),
    ([0.936303630124, 2.001190815972, 2.687695194441], [0.380402032251, 0.060435646035, 0.026459242408]),
    ([0.221135689711, 0.753655801097, 4.735173857128], [0.268533962960, 0.153131503439, 0.000741552926]),
    ([2.906351857604, 1.319268869652, 2.921582084061], [0.001331669962, 0.001511512225, 0.000398660645]),
    ([2.800674622442, 0.689861535750, 0.540750518866], [0.007935889693, 0.039881045001, 0.075393254453]),
    ([1.540848560594, 2.818141537910, 3.382462220961], [0.011095621269, 0.011676756187, 0.000490952759]),
    ([0.307075012313, 2.181121693529, 2.972585710578], [0.195462639239, 0.002082204425, 0.002365341165]),
    ([0.293466224379, 1.709775227843, 4.735173857128], [0.000448549006, 0.001211992790, 0.000741552926]),
    ([0.134624175759, 0.452232361307, 3.066079040226], [0.102070314563, 0.236952116874, 0.001163480078]),
    ([2.831242618893, 1.023142311071, 1.351342547104], [0.001348012045, 0.005678319274, 0.004352046954]),
    ([1.804405456500, 1.804405456500, 0.135662044516], [0.000682887706, 0.000682887706, 0.007976576724]),
    ([0.177613084918, 0.244501681349, 0.155768482525], [0.377003989359, 0.079462380602, 0.448887451080]),
];

fn raw(published: &Published) -> Coefficients {
    Coefficients { absorption: published.absorption, scattering: published.scattering }
}

fn off(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|channel| (a[channel] - b[channel]).abs()).fold(0.0, f64::max)
}

fn layers_differ(a: Layer, b: Layer) -> f64 {
    off(a.reflectance, b.reflectance)
        .max(off(a.reflectance_from_below, b.reflectance_from_below))
        .max(off(a.transmittance, b.transmittance))
}

fn coefficients(largest: f64) -> impl Strategy<Value = Coefficients> {
    let channels = || prop::array::uniform3(prop_oneof![Just(0.0), 0.0..largest]);
    (channels(), channels()).prop_map(|(absorption, scattering)| Coefficients { absorption, scattering })
}

fn ground() -> impl Strategy<Value = LinearRgb> {
    prop::array::uniform3(0.0f64..=1.0).prop_map(LinearRgb)
}

#[test]
fn stacked_mixtures_match_independent_values() {
    for Case { ground, glazes, seen } in &CASES {
        let paints = figure_5().iter().map(raw).collect::<Vec<_>>();
        let (mut at_once, mut by_layers) = (LinearRgb(*ground), LinearRgb(*ground));
        let mut stack = Layer::CLEAR;
        for parts in glazes {
            let parts = parts.map(|(number, amount)| (&paints[number], amount));
            let (mixed, thickness) = mixture(parts);
            let layer = mixed.layer(thickness);
            at_once = glaze(parts, at_once);
            by_layers = layer.over_ground(by_layers);
            stack = layer.over(stack);
        }
        for got in [at_once, by_layers, stack.over_ground(LinearRgb(*ground))] {
            assert!(off(got.0, *seen) < 1e-6, "{got:?}, not {seen:?}");
        }
    }
}

#[test]
fn published_colors_are_kept() {
    for published in &figure_5() {
        let linear = Coefficients::linear_from_published(published);
        for ground in [LinearRgb::WHITE, LinearRgb::BLACK] {
            let shown = linear.layer(1.0).over_ground(ground).to_srgb();
            let printed = raw(published).layer(1.0).over_ground(ground);
            assert!(off(shown.0, printed.0) < 1e-6, "{published:?}: {shown:?}, not {printed:?}");
        }
    }
}

#[test]
fn linear_coefficients_match_independent_values() {
    for (published, (absorption, scattering)) in figure_5().iter().zip(LINEAR) {
        let linear = Coefficients::linear_from_published(published);
        assert!(off(linear.absorption, absorption) < 1e-6, "{linear:?}");
        assert!(off(linear.scattering, scattering) < 1e-6, "{linear:?}");
    }
}

#[test]
fn the_margin_changes_none_of_the_published() {
    for published in &figure_5() {
        let layer = raw(published).layer(1.0);
        let (white, black) = (layer.over_ground(LinearRgb::WHITE), layer.over_ground(LinearRgb::BLACK));
        for channel in 0..3 {
            let (white, black) = (decode_srgb(white.0[channel]), decode_srgb(black.0[channel]));
            assert!(APPEARANCE_MARGIN <= black && black + APPEARANCE_MARGIN <= white);
            assert!(white <= 1.0 - APPEARANCE_MARGIN);
        }
    }
}

#[test]
fn no_thickness_is_clear() {
    for thickness in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
        assert_eq!(raw(&figure_5()[1]).layer(thickness), Layer::CLEAR);
    }
    let film = raw(&figure_5()[1]).layer(1e-300);
    assert!(layers_differ(film, Layer::CLEAR) < 1e-15, "{film:?}");
}

#[test]
fn thin_layers_are_linear_in_thickness() {
    let paint = raw(&figure_5()[1]);
    for thickness in [1e-12, 1e-9, 1e-6] {
        let layer = paint.layer(thickness);
        for channel in 0..3 {
            let slope = layer.reflectance[channel] / thickness;
            assert!((slope - paint.scattering[channel]).abs() < 1e-5, "{thickness}: {slope}");
        }
    }
}

#[test]
fn thick_layers_reach_the_masstone() {
    for published in &figure_5() {
        let paint = raw(published);
        for thickness in [1e4, 1e12, 1e300, f64::INFINITY] {
            let layer = paint.layer(thickness);
            for channel in 0..3 {
                let ratio = paint.absorption[channel] / paint.scattering[channel];
                let masstone = 1.0 + ratio - (ratio * ratio + 2.0 * ratio).sqrt();
                assert!((layer.reflectance[channel] - masstone).abs() < 1e-9, "{published:?} {thickness}");
                assert!(layer.transmittance[channel] < 1e-30);
            }
        }
    }
}

#[test]
fn without_scattering_light_is_absorbed_exponentially_twice() {
    let dye = Coefficients { absorption: [0.0, 0.5, 3.0], scattering: [0.0; 3] };
    let seen = dye.layer(0.7).over_ground(LinearRgb::WHITE).0;
    let wanted = [0.0, 0.5, 3.0].map(|k: f64| (-2.0 * k * 0.7).exp());
    assert!(off(seen, wanted) < 1e-15, "{seen:?}");
}

#[test]
fn without_absorption_no_light_is_lost() {
    let white = Coefficients { absorption: [0.0; 3], scattering: [1e-9, 1.0, 1e6] };
    for thickness in [0.3, 1e9, f64::INFINITY] {
        let layer = white.layer(thickness);
        for channel in 0..3 {
            assert!((layer.reflectance[channel] + layer.transmittance[channel] - 1.0).abs() < 1e-12);
        }
        assert!(off(layer.over_ground(LinearRgb::WHITE).0, [1.0; 3]) < 1e-9);
    }
}

#[test]
fn impossible_appearances_name_channel_and_cure() {
    let white = LinearRgb([0.9, 0.5, 0.9]);
    let error = Coefficients::from_appearance(white, LinearRgb([0.1, 0.6, 0.1])).unwrap_err();
    assert_eq!(error, ImpossibleAppearance { channel: "green", over_white: 0.5, over_black: 0.6 });
    assert!(error.hint().contains("green over white brighter"), "{}", error.hint());
    for (w, b, cure) in [
        (0.5, 0.0, "over black slightly above 0"),
        (1.0, 0.5, "over white slightly below 1"),
        (0.0, 0.0, "over white above 0"),
        (1.0, 1.0, "lower red over black"),
        (f64::NAN, 0.5, "a number"),
    ] {
        let error = Coefficients::from_appearance(LinearRgb([w; 3]), LinearRgb([b; 3])).unwrap_err();
        assert!(error.hint().contains(cure), "{error}: {}", error.hint());
    }
}

#[test]
fn swatches_may_touch_black_and_white() {
    let swatch = |w: [f64; 3], b: [f64; 3]| Coefficients::from_swatch(Srgb(w), Srgb(b));
    let paint = swatch([1.0, 0.5, 0.1], [0.0; 3]).unwrap();
    let shown = paint.layer(1.0).over_ground(LinearRgb::WHITE).to_srgb().0;
    assert!(off(shown, [1.0, 0.5, 0.1]) < 1e-5, "{shown:?}");
    assert!(swatch([1.0, 0.5, 0.0], [0.0; 3]).is_err());
    assert!(swatch([1.1, 0.5, 0.5], [0.0; 3]).is_err());
    assert!(swatch([0.4, 0.5, 0.5], [0.4, 0.1, 0.1]).is_err());
}

#[test]
fn a_row_is_its_pixels() {
    let paints = [raw(&figure_5()[0]), raw(&figure_5()[10])];
    let amounts = [[0.0f32, 0.5, 0.0, f32::NAN], [0.0, 0.25, 1.5, -1.0]];
    let mut row = [LinearRgb([0.9, 0.8, 0.7]); 4];
    glaze_row(&paints, &[&amounts[0], &amounts[1]], &mut row);
    for x in 0..4 {
        let parts = (0..2).map(|k| (&paints[k], f64::from(amounts[k][x])));
        assert_eq!(row[x], glaze(parts, LinearRgb([0.9, 0.8, 0.7])));
    }
    assert_eq!([row[0], row[3]], [LinearRgb([0.9, 0.8, 0.7]); 2]);
}

#[test]
fn a_mixture_of_nothing_is_nothing() {
    assert_eq!(mixture([]), (Coefficients::default(), 0.0));
    assert_eq!(mixture([(&raw(&figure_5()[0]), 0.0)]), (Coefficients::default(), 0.0));
}

proptest! {
    #[test]
    fn layers_make_no_light(
        paint in prop_oneof![coefficients(4.0), coefficients(1e-9), coefficients(1e6)],
        thickness in prop_oneof![0.0f64..3.0, 0.0f64..1e-12, 0.0f64..1e15],
    ) {
        let layer = paint.layer(thickness);
        for channel in 0..3 {
            let (r, t) = (layer.reflectance[channel], layer.transmittance[channel]);
            prop_assert!(r >= 0.0 && t >= 0.0 && r + t <= 1.0 + 1e-12, "{r} {t}");
        }
    }

    #[test]
    fn a_thickness_splits(paint in coefficients(4.0), a in 0.0f64..3.0, b in 0.0f64..3.0) {
        let split = paint.layer(a).over(paint.layer(b));
        prop_assert!(layers_differ(split, paint.layer(a + b)) < 1e-12);
    }

    #[test]
    fn over_is_associative(paints in prop::array::uniform3(coefficients(4.0)), ground in ground()) {
        let [a, b, c] = paints.map(|paint| paint.layer(0.8));
        prop_assert!(layers_differ(a.over(b).over(c), a.over(b.over(c))) < 1e-12);
        let glazed = a.over_ground(b.over_ground(ground));
        prop_assert!(off(a.over(b).over_ground(ground).0, glazed.0) < 1e-12);
    }

    #[test]
    fn clear_changes_nothing(paint in coefficients(4.0), ground in ground()) {
        let layer = paint.layer(1.0);
        prop_assert!(layers_differ(layer.over(Layer::CLEAR), layer) < 1e-15);
        prop_assert!(layers_differ(Layer::CLEAR.over(layer), layer) < 1e-15);
        prop_assert_eq!(Layer::CLEAR.over_ground(ground), ground);
    }

    #[test]
    fn more_paint_over_white_is_darker(paint in coefficients(4.0), x in 0.0f64..3.0, more in 0.0f64..1.0) {
        let over = |x| paint.layer(x).over_ground(LinearRgb::WHITE).0;
        for channel in 0..3 {
            prop_assert!(over(x + more)[channel] <= over(x)[channel] + 1e-12);
        }
    }

    #[test]
    fn appearance_round_trips(
        pairs in prop::array::uniform3((1e-5f64..0.999, 1e-5f64..0.999)),
    ) {
        let white = pairs.map(|(a, b)| a.max(b) + 1e-4);
        let black = pairs.map(|(a, b)| a.min(b));
        let paint = Coefficients::from_appearance(LinearRgb(white), LinearRgb(black)).unwrap();
        let layer = paint.layer(1.0);
        prop_assert!(off(layer.over_ground(LinearRgb::WHITE).0, white) < 1e-9);
        prop_assert!(off(layer.over_ground(LinearRgb::BLACK).0, black) < 1e-9);
    }

    #[test]
    fn coefficients_round_trip(
        absorption in prop::array::uniform3(1e-3f64..4.0),
        scattering in prop::array::uniform3(1e-3f64..1.5),
    ) {
        let paint = Coefficients { absorption, scattering };
        let layer = paint.layer(1.0);
        let again = Coefficients::from_appearance(
            layer.over_ground(LinearRgb::WHITE),
            layer.over_ground(LinearRgb::BLACK),
        ).unwrap();
        prop_assert!(off(again.absorption, absorption) < 1e-6, "{again:?}");
        prop_assert!(off(again.scattering, scattering) < 1e-6, "{again:?}");
    }

    #[test]
    fn a_glaze_is_the_layer_of_its_mixture(
        paints in prop::array::uniform3(coefficients(4.0)),
        amounts in prop::array::uniform3(0.0f64..2.0),
        ground in ground(),
    ) {
        let parts = || paints.iter().zip(amounts);
        let (mixed, thickness) = mixture(parts());
        let by_layer = mixed.layer(thickness).over_ground(ground);
        prop_assert!(off(glaze(parts(), ground).0, by_layer.0) < 1e-12);
    }

    #[test]
    fn every_published_pair_has_linear_coefficients(paint in prop_oneof![coefficients(4.0), coefficients(1e6)]) {
        let published = Published { absorption: paint.absorption, scattering: paint.scattering };
        let linear = Coefficients::linear_from_published(&published);
        let shown = linear.layer(1.0).over_ground(LinearRgb::WHITE).0.map(encode_srgb);
        let printed = paint.layer(1.0).over_ground(LinearRgb::WHITE).0;
        // Twice the margin, encoded, at the steep end of the transfer curve.
        prop_assert!(off(shown, printed) < 12.92 * 2.0 * APPEARANCE_MARGIN + 1e-9, "{shown:?} {printed:?}");
        for value in linear.absorption.into_iter().chain(linear.scattering) {
            prop_assert!(value.is_finite() && value > 0.0);
        }
    }
}
