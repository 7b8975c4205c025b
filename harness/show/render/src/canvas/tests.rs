//! What triangles leave on the canvas.

use super::*;

fn canvas() -> Canvas {
    // One sample a metre, 10 × 10 of them; z = 0 is 5 m below the eye.
    Canvas::new(Camera::above(V3::new(5.0, 5.0, 5.0), 1.0, [10, 10]))
}

fn square(low: [f64; 2], high: [f64; 2], z: f64) -> [[V3; 3]; 2] {
    let p = |x: f64, y: f64| V3::new(x, y, z);
    let [a, b] = [p(low[0], low[1]), p(high[0], low[1])];
    let [c, d] = [p(high[0], high[1]), p(low[0], high[1])];
    [[a, b, c], [a, c, d]]
}

#[test]
fn a_square_covers_the_samples_whose_middles_are_in_it_and_each_once() {
    let mut canvas = canvas();
    let mut covered = [0; 100];
    for t in square([2.2, 1.0], [7.5, 4.0], 0.0) {
        let own = t.map(|p| canvas.camera.own(&p));
        let spots = own.map(|p| canvas.camera.spot(&p));
        runs(10, 0..10, &spots, |run| {
            covered[run.first..run.first + run.count].iter_mut().for_each(|n| *n += 1);
        });
        canvas.face(&t, Faces::Front, solid([1, 2, 3]));
    }
    let samples = canvas.exposed();
    for (k, count) in covered.into_iter().enumerate() {
        // x from 2.5 to 6.5 (7.5 is on the right edge), y from 1.5 to 3.5: rows 6 to 8 from the top.
        let (row, col) = (k / 10, k % 10);
        let inside = (2..7).contains(&col) && (6..9).contains(&row);
        assert_eq!(count, u32::from(inside), "{row} {col}");
        assert_eq!(seen(samples.paint[k]), if inside { Seen::Solid([1, 2, 3]) } else { Seen::Sky });
    }
}

#[test]
fn what_is_nearer_hides_what_is_behind_it_in_whatever_order_they_come() {
    let (low, high) = (square([0.0, 0.0], [10.0, 10.0], 0.0), square([3.0, 3.0], [6.0, 6.0], 1.0));
    for order in [[0, 1], [1, 0]] {
        let mut canvas = canvas();
        for which in order {
            for t in [&low, &high][which] {
                canvas.face(t, Faces::Front, solid([which as u8; 3]));
            }
        }
        let canvas = canvas.exposed();
        assert_eq!(seen(canvas.paint[5 * 10 + 4]), Seen::Solid([1; 3]));
        assert_eq!(seen(canvas.paint[5 * 10 + 8]), Seen::Solid([0; 3]));
        assert!((canvas.near[5 * 10 + 4] + 4.0).abs() < 1e-5, "4 m below the eye");
    }
}

#[test]
fn faces_that_look_away_are_not_drawn() {
    let mut canvas = canvas();
    for [a, b, c] in square([0.0, 0.0], [10.0, 10.0], 0.0) {
        canvas.face(&[a, c, b], Faces::Front, solid([9; 3]));
    }
    assert!(canvas.exposed().paint.iter().all(|&p| p == SKY));
}

#[test]
fn a_triangle_that_passes_the_camera_is_cut_before_it() {
    // A floor 1 m below an eye that looks north, from behind the eye to far ahead.
    let camera = Camera::looking(V3::zeros(), V3::y(), std::f64::consts::FRAC_PI_2, 0.5, [100, 100]);
    let mut canvas = Canvas::new(camera);
    for t in square([-1000.0, -10.0], [1000.0, 1e6], -1.0) {
        canvas.face(&t, Faces::Front, solid([7; 3]));
    }
    let canvas = canvas.exposed();
    for row in 0..100 {
        let expected = if row >= 50 { Seen::Solid([7; 3]) } else { Seen::Sky };
        assert_eq!(seen(canvas.paint[row * 100 + 50]), expected, "{row}");
    }
    // 25 samples below the horizon with a focal length of 50: the floor is 2 m away there.
    let near = canvas.near[74 * 100 + 50];
    assert!((1.0 / near - 50.0 / 24.5).abs() < 1e-4, "{near}");
}

#[test]
fn marks_lie_on_ground_alone_and_only_where_it_is_not_hidden() {
    let mut canvas = canvas();
    for t in square([0.0, 0.0], [8.0, 10.0], 0.0) {
        canvas.face(&t, Faces::Front, GROUND);
    }
    for t in square([3.0, 0.0], [6.0, 10.0], 1.0) {
        canvas.face(&t, Faces::Front, solid([1; 3]));
    }
    for t in square([0.0, 4.0], [10.0, 5.0], 0.01) {
        canvas.lay(&t, mark([2; 3]), 0.1);
    }
    let canvas = canvas.exposed();
    let row: Vec<Seen> = (0..10).map(|k| seen(canvas.paint[5 * 10 + k])).collect();
    let (m, s) = (Seen::Mark([2; 3]), Seen::Solid([1; 3]));
    assert_eq!(row, [m, m, m, s, s, s, m, m, Seen::Sky, Seen::Sky]);
}

#[test]
fn strips_together_have_the_samples_of_the_whole() {
    // Two strips of 40 rows and one of 21.
    let camera = Camera::looking(V3::zeros(), V3::y(), 1.0, 0.1, [1000, 101]);
    let mut canvas = Canvas::new(camera);
    for k in 0..40_u8 {
        let x = f64::from(k) - 20.0;
        let corners = [V3::new(x, 9.0, -3.0), V3::new(x + 5.0, 11.0, -1.0), V3::new(x + 1.0, 10.0, 4.0)];
        canvas.face(&corners, Faces::Both, solid([k; 3]));
    }
    let (mut near, mut paint) = (Vec::new(), Vec::new());
    let mut strip = Strip { near: Vec::new(), paint: Vec::new() };
    let rows: Vec<_> = canvas.strips().collect();
    assert_eq!(rows, [0..40, 40..80, 80..101]);
    for rows in rows {
        canvas.expose(rows, &mut strip);
        near.extend_from_slice(&strip.near);
        paint.extend_from_slice(&strip.paint);
    }
    let whole = canvas.exposed();
    assert!(whole.near == near && whole.paint == paint);
    assert!(paint.iter().any(|p| *p != SKY));
}
