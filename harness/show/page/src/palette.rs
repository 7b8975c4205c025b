//! Whether the colours of series can be told apart, also by eyes that lack a kind of cone, and whether they stand out.
//!
//! Colours are compared by CIEDE2000 (Sharma, Wu and Dalal 2005), as the eye without one kind of cone sees them by the matrices of
//! Machado, Oliveira and Fernandes (2009, severity 1) for linear sRGB. Contrast is that of WCAG 2.2, which wants 3:1 of
//! graphics and 4.5:1 of text.

use std::f64::consts::PI;

use crate::{SERIES_COLOURS, TABLE_STYLE};

/// The least difference between two colours: about five times what is just noticed beside each other (2.3).
const APART: f64 = 11.0;

type Vector = [f64; 3];

const EYES: [(&str, [Vector; 3]); 4] = [
    ("all cones", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    (
        "protanopia",
        [
            [0.152_286, 1.052_583, -0.204_868],
            [0.114_503, 0.786_281, 0.099_216],
            [-0.003_882, -0.048_116, 1.051_998],
        ],
    ),
    (
        "deuteranopia",
        [
            [0.367_322, 0.860_646, -0.227_968],
            [0.280_085, 0.672_501, 0.047_413],
            [-0.011_820, 0.042_940, 0.968_881],
        ],
    ),
    (
        "tritanopia",
        [
            [1.255_528, -0.076_749, -0.178_779],
            [-0.078_411, 0.930_809, 0.147_602],
            [0.004_733, 0.691_367, 0.303_900],
        ],
    ),
];

fn times(m: &[Vector; 3], v: Vector) -> Vector {
    std::array::from_fn(|k| m[k][0] * v[0] + m[k][1] * v[1] + m[k][2] * v[2])
}

/// Linear sRGB of `#rrggbb` or `#rgb`.
fn linear(text: &str) -> Vector {
    let digits = text.trim_start_matches('#');
    std::array::from_fn(|k| {
        let part =
            if digits.len() == 3 { digits[k..=k].repeat(2) } else { digits[2 * k..2 * k + 2].to_owned() };
        let c = f64::from(u8::from_str_radix(&part, 16).unwrap()) / 255.0;
        if c <= 0.040_45 { c / 12.92 } else { vb_math::pow((c + 0.055) / 1.055, 2.4) }
    })
}

/// CIELAB under D65.
fn lab(linear: Vector) -> Vector {
    let xyz = times(
        &[
            [0.412_456_4, 0.357_576_1, 0.180_437_5],
            [0.212_672_9, 0.715_152_2, 0.072_175_0],
            [0.019_333_9, 0.119_192_0, 0.950_304_1],
        ],
        linear.map(|c| c.clamp(0.0, 1.0)),
    );
    let f = |t: f64| {
        if t > 216.0 / 24_389.0 { vb_math::pow(t, 1.0 / 3.0) } else { (24_389.0 / 27.0 * t + 16.0) / 116.0 }
    };
    let [x, y, z] = [f(xyz[0] / 0.950_47), f(xyz[1]), f(xyz[2] / 1.088_83)];
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// CIEDE2000 between two colours in CIELAB (Sharma et al. 2005, equations 2 to 22).
fn difference(p: Vector, q: Vector) -> f64 {
    let seventh = |c: f64| (vb_math::pow(c, 7.0) / (vb_math::pow(c, 7.0) + vb_math::pow(25.0, 7.0))).sqrt();
    let chroma = 0.5 * (vb_math::hypot(p[1], p[2]) + vb_math::hypot(q[1], q[2]));
    let stretch = 1.0 + 0.5 * (1.0 - seventh(chroma));
    let polar = |v: Vector| {
        let a = stretch * v[1];
        let hue = vb_math::atan2(v[2], a).to_degrees();
        (vb_math::hypot(a, v[2]), if hue < 0.0 { hue + 360.0 } else { hue })
    };
    let ((c1, h1), (c2, h2)) = (polar(p), polar(q));
    let grey = c1 * c2 == 0.0;
    let turn = match h2 - h1 {
        _ if grey => 0.0,
        d if d > 180.0 => d - 360.0,
        d if d < -180.0 => d + 360.0,
        d => d,
    };
    let (dl, dc) = (q[0] - p[0], c2 - c1);
    let dh = 2.0 * (c1 * c2).sqrt() * vb_math::sin(0.5 * turn.to_radians());
    let (l, c) = (0.5 * (p[0] + q[0]), 0.5 * (c1 + c2));
    let h = match 0.5 * (h1 + h2) {
        m if grey => 2.0 * m,
        m if (h1 - h2).abs() <= 180.0 => m,
        m if h1 + h2 < 360.0 => m + 180.0,
        m => m - 180.0,
    };
    let wave = |factor: f64, phase: f64| vb_math::cos((factor * h + phase) * PI / 180.0);
    let t = 1.0 - 0.17 * wave(1.0, -30.0) + 0.24 * wave(2.0, 0.0) + 0.32 * wave(3.0, 6.0)
        - 0.2 * wave(4.0, -63.0);
    let far = (l - 50.0) * (l - 50.0);
    let (sl, sc, sh) = (1.0 + 0.015 * far / (20.0 + far).sqrt(), 1.0 + 0.045 * c, 1.0 + 0.015 * c * t);
    let bend = (h - 275.0) / 25.0;
    let rotation = -2.0 * seventh(c) * vb_math::sin(60.0 * vb_math::exp(-bend * bend) * PI / 180.0);
    let (dl, dc, dh) = (dl / sl, dc / sc, dh / sh);
    (dl * dl + dc * dc + dh * dh + rotation * dc * dh).sqrt()
}

/// WCAG's contrast between two colours.
fn contrast(a: &str, b: &str) -> f64 {
    let luminance = |c: &str| {
        let [r, g, b] = linear(c);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    let (x, y) = (luminance(a), luminance(b));
    (x.max(y) + 0.05) / (x.min(y) + 0.05)
}

/// The colour of this name in the style's light, dark or printed page.
fn named(page: &str, name: &str) -> String {
    let from = TABLE_STYLE.find(page).unwrap();
    let key = format!("--{name}:");
    let at = from + TABLE_STYLE[from..].find(&key).unwrap() + key.len();
    TABLE_STYLE[at..].split([';', '}']).next().unwrap().to_owned()
}

const PAGES: [&str; 3] =
    [":root{color-scheme:light dark", "@media(prefers-color-scheme:dark)", "@media print"];

#[test]
fn differences_are_those_of_the_published_pairs() {
    // Sharma, Wu and Dalal 2005, table 1: pairs 1, 7, 17 and 34.
    for (p, q, expected) in [
        ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
        ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
        ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
        ([2.0776, 0.0795, -1.1350], [0.9033, -0.0636, -0.5514], 0.9082),
    ] {
        let found = difference(p, q);
        assert!((found - expected).abs() < 1e-4, "{found} {expected}");
        assert!((difference(q, p) - expected).abs() < 1e-4);
    }
    // WCAG 2.2: black on white.
    assert!((contrast("#000", "#ffffff") - 21.0).abs() < 1e-9);
}

#[test]
fn colours_of_series_are_told_apart_by_all_eyes_and_stand_out_in_light_and_dark() {
    for page in PAGES {
        let colours: Vec<String> = (0..SERIES_COLOURS).map(|k| named(page, &format!("c{k}"))).collect();
        for (eye, matrix) in &EYES {
            let seen: Vec<Vector> = colours.iter().map(|c| lab(times(matrix, linear(c)))).collect();
            for (k, p) in seen.iter().enumerate() {
                for (other, q) in seen[..k].iter().enumerate() {
                    let d = difference(*p, *q);
                    assert!(
                        d >= APART,
                        "{page}, {eye}: {} and {} differ by {d:.1}",
                        colours[other],
                        colours[k]
                    );
                }
            }
        }
        for (k, colour) in colours.iter().enumerate() {
            for ground in ["bg", "card"] {
                let c = contrast(colour, &named(page, ground));
                assert!(c >= 3.0, "{page}: c{k} on {ground} has {c:.2}");
            }
        }
    }
}

#[test]
fn texts_are_legible_in_light_and_dark() {
    for page in PAGES {
        for (text, ground) in [("fg", "bg"), ("fg", "card"), ("soft", "bg"), ("soft", "card")] {
            let c = contrast(&named(page, text), &named(page, ground));
            assert!(c >= 4.5, "{page}: {text} on {ground} has {c:.2}");
        }
    }
}
