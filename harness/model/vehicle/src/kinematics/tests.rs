//! Tables against closed-form geometry and against independent solutions of the reference sheets.

use super::*;
use crate::VehicleSpec;
use vb_math::angle::{degrees, radians};
use vb_math::{acos, asin, atan2, cos, hypot, sin};

mod sheets;

/// An axle of which only the linkage matters.
fn axle(steering: &str, suspension: &str) -> Axle {
    let text = format!(
        "{{name: a, position: [0, 0, 0], driven: true, unsprung_mass: 1, spin_inertia: 1, brake_torque: 1, \
         {steering} suspension: {suspension}}}"
    );
    vb_files::yaml::parse(&text).unwrap()
}

fn toe(p: &WheelPose) -> f64 {
    degrees(atan2(-p.axis.x, p.axis.y))
}

/// Of the left wheel, top outward: the axle points to the left, whose end then goes down.
fn camber(p: &WheelPose) -> f64 {
    degrees(asin(-p.axis.z))
}

fn at(k: &AxleKinematics, side: Side, travel: f64, command: f64) -> WheelPose {
    k.wheel(side, [travel; 2], command)
}

const STRUT: &str = "struts: [{chassis: [0, 0.6, 0.6], end: [0, 0.6, 0], part: arm, spring: {type: linear, \
                     stiffness: 1, free_length: 1}}]";

const DOUBLE_WISHBONE: &str = "type: double_wishbone, spindle: [0, 0.9, 0], \
    upper_arm_front: [0.2, 0.4, 0.2], upper_arm_rear: [-0.2, 0.4, 0.2], upper_ball_joint: [0, 0.8, 0.2], \
    lower_arm_front: [0.2, 0.4, -0.2], lower_arm_rear: [-0.2, 0.4, -0.2], lower_ball_joint: [0, 0.8, -0.2], \
    tie_rod_inner: [-0.2, 0.4, -0.1], tie_rod_outer: [-0.2, 0.8, -0.1]";

#[test]
fn parallel_wishbones_of_equal_length_keep_camber_and_toe_and_move_on_a_circle() {
    let k = AxleKinematics::solve(&axle(
        "",
        &format!("{{linkage: {{{DOUBLE_WISHBONE}}}, range: [-0.2, 0.2], {STRUT}}}"),
    ))
    .unwrap();
    for i in 0..=8 {
        let travel = -0.2 + 0.05 * f64::from(i);
        let p = at(&k, Side::Left, travel, 0.0);
        assert!(toe(&p).abs() < 1e-9 && camber(&p).abs() < 1e-9, "{travel}");
        // Arms of 0.4 m turn by asin(travel / 0.4).
        let y = 0.5 + (0.16 - travel * travel).sqrt();
        assert!((p.hub.y - y).abs() < 1e-9, "{travel}: {} {y}", p.hub.y);
        let right = at(&k, Side::Right, travel, 0.0);
        assert!((right.hub.y + y).abs() < 1e-9 && (right.hub.x - p.hub.x).abs() < 1e-15);
    }
}

#[test]
fn five_rods_at_the_joints_of_a_double_wishbone_move_the_wheel_as_the_wishbones_do() {
    let wishbones =
        VehicleSpec::parse(include_str!("../../../../../tasks/vehicles/hmmwv-released.yaml"), "hmmwv")
            .unwrap();
    let mut rods = wishbones.axles[0].clone();
    let Linkage::DoubleWishbone(l) = &rods.suspension.linkage else { panic!("wishbones") };
    let rod = |chassis, carrier| crate::suspension::Rod { chassis, carrier };
    rods.suspension.linkage = Linkage::Multilink(crate::suspension::Multilink {
        spindle: l.spindle,
        links: [
            rod(l.upper_arm_front, l.upper_ball_joint),
            rod(l.upper_arm_rear, l.upper_ball_joint),
            rod(l.lower_arm_front, l.lower_ball_joint),
            rod(l.lower_arm_rear, l.lower_ball_joint),
        ],
        tie_rod_inner: l.tie_rod_inner,
        tie_rod_outer: l.tie_rod_outer,
    });
    let (a, b) = (AxleKinematics::solve(&wishbones.axles[0]).unwrap(), AxleKinematics::solve(&rods).unwrap());
    for (travel, command) in [(0.0, 1.0), (0.13, -0.5), (-0.11, 0.3)] {
        let (p, q) = (at(&a, Side::Left, travel, command), at(&b, Side::Left, travel, command));
        assert!((p.hub - q.hub).norm() < 1e-10 && (p.axis - q.axis).norm() < 1e-10);
        assert!((p.struts[0] - q.struts[0]).abs() < 1e-10);
    }
}

#[test]
fn the_hub_of_a_trailing_arm_follows_its_circle_and_a_torsion_bar_turns_with_it() {
    // Pivot 0.4 m ahead and 0.1 m above the hub.
    let k = AxleKinematics::solve(&axle(
        "",
        "{linkage: {type: torsion_arm, spindle: [0, 1, 0], pivot: [0.4, 0.8, 0.1], axis: [0, 1, 0], \
         torsion: {stiffness: 1000}}, range: [-0.15, 0.25]}",
    ))
    .unwrap();
    let radius = hypot(0.4, 0.1);
    for travel in [-0.15, -0.1, 0.05, 0.175, 0.25] {
        let p = at(&k, Side::Left, travel, 0.0);
        assert!((p.hub.y - 1.0).abs() < 1e-12 && (p.axis - V3::y()).norm() < 1e-12);
        let x = 0.4 - (radius * radius - (travel - 0.1) * (travel - 0.1)).sqrt();
        assert!((p.hub.x - x).abs() < 1e-7, "{travel}: {} {x}", p.hub.x);
        // The arm's angle from the design position, taken negative.
        let angle = asin((travel - 0.1) / radius) - asin(-0.1 / radius);
        assert!((p.struts[0] + angle).abs() < 1e-6, "{travel}: {} {angle}", p.struts[0]);
    }
}

#[test]
fn a_swing_arm_cambers_by_its_angle_and_its_roll_centre_lies_on_the_line_through_the_pivot() {
    // Half axle that turns about a longitudinal axis at y = 0.2 m, 0.1 m below the hub; wheel radius 0.4 m.
    let k = AxleKinematics::solve(&axle(
        "",
        "{linkage: {type: torsion_arm, spindle: [0, 1, 0], pivot: [0.3, 0.2, -0.1], axis: [1, 0, 0], \
         torsion: {stiffness: 1000}}, range: [-0.2, 0.2]}",
    ))
    .unwrap();
    let radius = hypot(0.8, 0.1);
    for travel in [-0.15, 0.05, 0.2] {
        let turned = asin((travel + 0.1) / radius) - asin(0.1 / radius);
        let p = at(&k, Side::Left, travel, 0.0);
        // Rising tilts the top inward.
        assert!((camber(&p) + degrees(turned)).abs() < 1e-5, "{travel}: {}", camber(&p));
    }
    let p = at(&k, Side::Left, 0.0, 0.0);
    let contact = p.hub - V3::z() * 0.4;
    let velocity = p.hub_rate + p.tilt_rate.cross(&V3::new(0.0, 0.0, -0.4));
    // Normal to the contact's path, cut with the middle plane (Kennedy–Aronhold).
    let roll_centre = contact.z + contact.y * velocity.y / velocity.z;
    let expected = -0.4 + (-0.1 + 0.4) / (1.0 - 0.2);
    assert!((roll_centre - expected).abs() < 1e-3, "{roll_centre} {expected}");
}

#[test]
fn the_motion_ratio_of_an_inclined_strut_is_that_of_the_triangle() {
    // Strut from (0.1, 0, 0.5) to the point (0.1, 0, 0) of an arm of 0.4 m with its pivot at the origin's height.
    let k = AxleKinematics::solve(&axle(
        "",
        "{linkage: {type: torsion_arm, spindle: [0, 1, 0], pivot: [0.4, 1, 0], axis: [0, 1, 0]}, \
         range: [-0.15, 0.15], struts: [{chassis: [0.25, 1, 0.5], end: [0.1, 1, 0], part: arm, spring: {type: \
         linear, stiffness: 1000, free_length: 0.6}, damper: {type: linear, coefficient: 1}}]}",
    ))
    .unwrap();
    for travel in [-0.1, 0.0, 0.09] {
        let p = at(&k, Side::Left, travel, 0.0);
        let angle = asin(travel / 0.4);
        // Pivot–strut end 0.3 m, pivot–strut top (−0.15, 0.5): cosine rule.
        let top = hypot(0.15, 0.5);
        let between = atan2(0.5, 0.15) - angle;
        let length = (0.09 + top * top - 2.0 * 0.3 * top * cos(between)).sqrt();
        assert!((p.struts[0] - length).abs() < 1e-7, "{travel}: {} {length}", p.struts[0]);
        let rate = -0.3 * top * sin(between) / length / (0.4 * cos(angle));
        assert!((p.strut_rates[0] - rate).abs() < 1e-4, "{travel}: {} {rate}", p.strut_rates[0]);
    }
}

#[test]
fn a_bars_arm_turns_with_its_drop_link() {
    // The drop link is long and upright, the bar's arm 0.2 m: its end rises as the link's lower end does.
    let bar = "anti_roll: {type: bar, stiffness: 1, pivot: [0.2, 0.5, 10], arm_end: [0, 0.6, 10], \
               link_end: [0, 0.6, -0.2], part: arm}";
    let text = format!("{{linkage: {{{DOUBLE_WISHBONE}}}, range: [-0.1, 0.1], {STRUT}, {bar}}}");
    let k = AxleKinematics::solve(&axle("", &text)).unwrap();
    for travel in [-0.08, 0.0, 0.06] {
        // The link's end is at half the arm's length.
        let rise = 0.5 * travel;
        let p = at(&k, Side::Left, travel, 0.0);
        let angle = asin(rise / 0.2);
        assert!((p.bar - angle).abs() < 2e-3, "{travel}: {} {angle}", p.bar);
        let right = at(&k, Side::Right, travel, 0.0);
        assert!((p.bar - right.bar).abs() < 1e-12);
    }
}

/// Solid axle on rods that are level at design height; knuckles with vertical kingpins.
fn solid_axle(tie_y: f64) -> Axle {
    axle(
        "steering: {type: rack_and_pinion, travel: 0.1},",
        &format!(
            "{{linkage: {{type: solid_axle, spindle: [0, 0.9, 0], beam: {{mass: 1, inertia: 0.1}}, \
             links: [{{chassis: [-1.5, 0.4, -0.1], carrier: [0, 0.4, -0.1]}}, \
             {{chassis: [-1.5, 0.6, 0.2], carrier: [0, 0, 0.2]}}], \
             knuckles: {{kingpin_lower: [0, 0.7, -0.1], kingpin_upper: [0, 0.7, 0.1], \
             tie_rod: [-0.2, {tie_y}, 0], drag_link_inner: [0.2, -0.6, 0], \
             by: {{type: toebar, drag_link_outer: [0.2, 0.7, 0]}}}}}}, range: [-0.15, 0.15], \
             struts: [{{chassis: [0, 0.5, 0.5], end: [0, 0.5, 0], part: beam, \
             spring: {{type: linear, stiffness: 1, free_length: 1}}}}]}}"
        ),
    )
}

/// Without knuckles, whose drag link steers a little as the beam moves.
fn unsteered(mut a: Axle) -> Axle {
    a.steering = None;
    if let Linkage::SolidAxle(l) = &mut a.suspension.linkage {
        l.knuckles = None;
    }
    a
}

/// With a narrower range: steered to full lock, some linkages lock near the ends of the straight one.
fn within(mut a: Axle, range: [f64; 2]) -> Axle {
    a.suspension.range = range;
    a
}

#[test]
fn a_parallelogram_tie_bar_turns_both_wheels_alike() {
    let k = AxleKinematics::solve(&solid_axle(0.7)).unwrap();
    for command in [-1.0, -0.5, 0.25, 1.0] {
        let angle = |s: Side| toe(&k.wheel(s, [0.0; 2], command));
        assert!((angle(Side::Left) - angle(Side::Right)).abs() < 1e-9, "{command}");
        assert!(angle(Side::Left).abs() > 3.0, "{command}: it steers: {}", angle(Side::Left));
    }
}

#[test]
fn a_trapezoid_tie_bar_turns_the_inner_wheel_more_by_the_angle_of_its_four_bar_linkage() {
    // Arms of 0.2 m to the rear and 0.05 m inwards.
    let k = AxleKinematics::solve(&solid_axle(0.65)).unwrap();
    let (arm, lean) = (hypot(0.2, 0.05), atan2(0.05, 0.2));
    for command in [-1.0, -0.5, 0.5, 1.0] {
        let angle = |s: Side| radians(toe(&k.wheel(s, [0.0; 2], command)));
        let (left, right) = (angle(Side::Left), angle(Side::Right));
        // End of the left arm; the right one lies where a circle of the bar's length cuts its own (cosine rule).
        let end = (-arm * cos(lean + left), 0.7 - arm * sin(lean + left));
        let (dx, dy) = (end.0, end.1 + 0.7);
        let reach = hypot(dx, dy);
        let bar = 1.3;
        let at_pivot = acos((arm * arm + reach * reach - bar * bar) / (2.0 * arm * reach));
        let direction = atan2(dy, dx) + at_pivot;
        // Direction of the right arm at rest: to the rear and inwards.
        let rest = atan2(0.05, -0.2);
        let expected = vb_math::angle::wrap(direction - rest);
        assert!((right - expected).abs() < 1e-6, "{command}: {right} {expected}");
        let (inner, outer) = if left > 0.0 { (left, right) } else { (right, left) };
        assert!(inner.abs() > outer.abs() + 1e-3, "{command}: inner {inner}, outer {outer}");
    }
}

#[test]
fn a_beam_rises_level_in_heave_and_turns_about_its_roll_centre_when_its_ends_part() {
    let k = AxleKinematics::solve(&unsteered(solid_axle(0.7))).unwrap();
    for travel in [-0.1, 0.05, 0.12] {
        let (l, r) = (k.wheel(Side::Left, [travel; 2], 0.0), k.wheel(Side::Right, [travel; 2], 0.0));
        assert!((l.hub.z - travel).abs() < 1e-9 && (r.hub.z - travel).abs() < 1e-9);
        assert!((l.hub.y - 0.9).abs() < 1e-9 && (l.hub.y + r.hub.y).abs() < 1e-9);
    }
    let travels = [0.09, -0.09];
    let (l, r) = (k.wheel(Side::Left, travels, 0.0), k.wheel(Side::Right, travels, 0.0));
    assert!((l.hub.z - 0.09).abs() < 1e-5 && (r.hub.z + 0.09).abs() < 1e-5);
    // 0.18 m over 1.8 m; the left end up leans both wheels to the right.
    let roll = asin(0.18 / (l.hub - r.hub).norm());
    assert!((camber(&l) + degrees(roll)).abs() < 1e-3, "{} {roll}", camber(&l));
    assert!(((l.hub - r.hub).norm() - 1.8).abs() < 1e-9, "the beam keeps its length");
    // The triangle's tip, 0.2 m above the beam, stays in the middle plane to first order: the middle below swings out.
    let middle = 0.5 * (l.hub + r.hub);
    assert!((middle.y - 0.2 * sin(roll)).abs() < 1e-3, "{}", middle.y);
}

#[test]
fn a_leaf_springs_axle_moves_on_the_arc_of_its_effective_link_and_rolls_about_its_seats() {
    let text = "{linkage: {type: leaf_axle, spindle: [0, 0.8, 0], beam: {mass: 1, inertia: 0.1}, \
                seat: [0, 0.5, 0.1], eye: [0.6, 0.5, 0.1]}, range: [-0.1, 0.1], struts: [{chassis: [0, 0.5, 0.6], \
                end: [0, 0.5, 0.1], part: beam, spring: {type: linear, stiffness: 1, free_length: 1}}]}";
    let k = AxleKinematics::solve(&axle("", text)).unwrap();
    for travel in [-0.1, 0.06] {
        let p = k.wheel(Side::Left, [travel; 2], 0.0);
        // SAE HS-788: ¾ of the fixed half.
        let x = 0.45 - (0.45 * 0.45 - travel * travel).sqrt();
        assert!((p.hub.x - x).abs() < 1e-6, "{travel}: {} {x}", p.hub.x);
    }
    let (l, r) = (k.wheel(Side::Left, [0.08, -0.08], 0.0), k.wheel(Side::Right, [0.08, -0.08], 0.0));
    let roll = asin(0.16 / 1.6);
    assert!((0.5 * (l.hub.y + r.hub.y) - 0.1 * sin(roll)).abs() < 1e-4);
}

#[test]
fn rates_are_the_derivatives_of_the_positions() {
    let v = VehicleSpec::parse(include_str!("../../../../../tasks/vehicles/hmmwv-released.yaml"), "hmmwv")
        .unwrap();
    let wheel = AxleKinematics::solve(&v.axles[0]).unwrap();
    let beam = AxleKinematics::solve(&solid_axle(0.65)).unwrap();
    let straight = AxleKinematics::solve(&unsteered(solid_axle(0.65))).unwrap();
    let h = 1e-6;
    for (k, side, travels, command) in [
        (&wheel, Side::Left, [0.031, 0.0], 0.3),
        (&wheel, Side::Right, [0.0, -0.077], -0.8),
        (&wheel, Side::Left, [0.123, 0.0], 0.1),
        (&wheel, Side::Left, [0.21, 0.0], 0.1),
        (&beam, Side::Left, [0.05, -0.03], 0.4),
        (&beam, Side::Right, [-0.11, 0.06], -0.7),
        (&beam, Side::Right, [-0.11, 0.2], 0.1),
        (&straight, Side::Left, [0.052, -0.03], 0.0),
        (&straight, Side::Right, [-0.11, 0.2], 0.0),
    ] {
        let at = |dq: f64, dc: f64| {
            let mut t = travels;
            t[side.index()] += dq;
            k.wheel(side, t, command + dc)
        };
        let p = at(0.0, 0.0);
        let (a, b) = (at(-h, 0.0), at(h, 0.0));
        assert!(((b.hub - a.hub) / (2.0 * h) - p.hub_rate).norm() < 1e-6, "{travels:?}");
        assert!(((b.struts[0] - a.struts[0]) / (2.0 * h) - p.strut_rates[0]).abs() < 1e-6);
        let turn = p.axis.cross(&((b.axis - a.axis) / (2.0 * h)));
        assert!((turn - p.tilt_rate).norm() < 1e-5, "{travels:?}: {turn} {}", p.tilt_rate);
        let (c, d) = (at(0.0, -h), at(0.0, h));
        assert!(((d.hub - c.hub) / (2.0 * h) - p.hub_steer_rate).norm() < 1e-5);
        let turn = p.axis.cross(&((d.axis - c.axis) / (2.0 * h)));
        assert!((turn - p.steer_tilt_rate).norm() < 1e-5, "{travels:?}: {turn} {}", p.steer_tilt_rate);
        // The bend of a steered knuckle over travel is left out.
        let bend = (b.hub_rate - a.hub_rate) / (2.0 * h) - p.hub_curvature;
        assert!(bend.norm() < 1e-4 || std::ptr::eq(k, &beam), "{travels:?}: {bend}");
    }
}

#[test]
fn an_oblique_gear_that_locks_is_refused_with_the_command() {
    let mut a = solid_axle(0.65);
    a.steering = Some(crate::suspension::SteeringGear::PitmanArm {
        pivot: [0.0, 0.5, 0.0],
        arm_end: [0.3, 0.5, 0.0],
        idler_pivot: [0.0, -0.5, 0.0],
        idler_end: [0.1, -0.5, 0.0],
        axis: [0.0, 0.0, 1.0],
        angle: 1.5,
    });
    let e = AxleKinematics::solve(&a).unwrap_err();
    assert!(matches!(e, LinkageError::SteeringLocked { .. }), "{e}");
    assert!(e.to_string().contains("command"), "{e}");
}

#[test]
fn rods_that_lock_are_refused_with_the_travels() {
    // Both rods of a side in line with each other: the beam can't rise.
    let text = "{linkage: {type: solid_axle, spindle: [0, 0.9, 0], beam: {mass: 1, inertia: 0.1}, \
                links: [{chassis: [-0.1, 0.4, 0], carrier: [0, 0.4, 0]}, {chassis: [0.1, 0.6, 0], \
                carrier: [0, 0, 0]}]}, range: [-0.15, 0.15], struts: [{chassis: [0, 0.5, 0.5], \
                end: [0, 0.5, 0], part: beam, spring: {type: linear, stiffness: 1, free_length: 1}}]}";
    let e = AxleKinematics::solve(&axle("", text)).unwrap_err();
    assert!(e.to_string().contains("travels -0.0") || e.to_string().contains("travels 0.0"), "{e}");
}
