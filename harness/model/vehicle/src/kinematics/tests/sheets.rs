//! Linkages of the reference sheets (vehicles/*.yaml), solved against their independent solutions there.

use super::*;

/// Over travel: values against a sheet's rows, within the rounding of its last digit.
fn follow(k: &AxleKinematics, rows: &[(f64, f64, f64, f64)]) {
    for &(travel, strut, toe_deg, camber_deg) in rows {
        let p = at(k, Side::Left, travel, 0.0);
        assert!((p.struts[0] - strut).abs() < 2e-5, "{travel}: strut {} {strut}", p.struts[0]);
        assert!((toe(&p) - toe_deg).abs() < 3e-3, "{travel}: toe {} {toe_deg}", toe(&p));
        assert!((camber(&p) - camber_deg).abs() < 3e-3, "{travel}: camber {} {camber_deg}", camber(&p));
    }
}

/// (command, left, right) in degrees.
fn steer(k: &AxleKinematics, rows: &[(f64, f64, f64)], tolerance: f64) {
    for &(command, left, right) in rows {
        for (side, expected) in [(Side::Left, left), (Side::Right, right)] {
            let got = toe(&at(k, side, 0.0, command));
            assert!((got - expected).abs() < tolerance, "{command} {side:?}: {got} {expected}");
        }
    }
}

fn hmmwv() -> VehicleSpec {
    VehicleSpec::parse(include_str!("../../../../../../tasks/vehicles/hmmwv-released.yaml"), "hmmwv").unwrap()
}

/// hmmwv.yaml, wheel_travel_table: travel, strut, toe left positive counter-clockwise, camber left positive top outward.
#[test]
fn strut_toe_and_camber_agree_with_the_independent_solution_of_the_reference_sheet() {
    let v = hmmwv();
    let k = |i: usize| AxleKinematics::solve(&v.axles[i]).unwrap();
    follow(
        &k(0),
        &[
            (-0.16, 0.53622, -3.6302, -1.0468),
            (-0.08, 0.44857, -0.7234, 1.0882),
            (0.0, 0.37023, 0.0, 0.0),
            (0.08, 0.29402, 0.2605, -2.5356),
            (0.16, 0.218, 0.3759, -6.3026),
        ],
    );
    follow(
        &k(1),
        &[
            (-0.16, 0.51918, 2.0679, 1.4862),
            (-0.08, 0.43988, 0.3619, 1.9608),
            (0.0, 0.36823, 0.0, 0.0),
            (0.08, 0.29886, -0.1583, -3.2837),
            (0.16, 0.22999, -0.2997, -7.7921),
        ],
    );
}

/// hmmwv.yaml: 21.178 deg left and 22.234 deg right at full left lock, with the original's rack, which `hmmwv-released` has.
#[test]
fn full_lock_turns_the_wheels_by_the_angles_of_the_reference_sheet_and_mirrors_to_the_right() {
    let text = include_str!("../../../../../../tasks/vehicles/hmmwv-released.yaml");
    let released = VehicleSpec::parse(text, "hmmwv-released").unwrap();
    let k = AxleKinematics::solve(&released.axles[0]).unwrap();
    steer(&k, &[(1.0, 21.178, 22.234), (-1.0, -22.234, -21.178)], 0.01);
}

/// gator.yaml, front: a single wishbone with the strut on the arm, and a rack.
#[test]
fn a_single_wishbone_moves_as_the_gators_sheet_says() {
    let a = axle(
        "steering: {type: rack_and_pinion, travel: 0.035},",
        "{linkage: {type: single_wishbone, spindle: [0, 0.56, -0.02], arm_front: [0.1, 0.06, 0], \
         arm_rear: [-0.1, 0.06, 0], kingpin_lower: [0, 0.48, -0.02], kingpin_upper: [0, 0.48, 0.1], \
         tie_rod_inner: [-0.05, 0.21, 0.08], tie_rod_outer: [-0.05, 0.48, 0.08]}, range: [-0.1, 0.1], \
         struts: [{chassis: [0, 0.28, 0.34], end: [0, 0.39, -0.015], part: arm, \
         spring: {type: linear, stiffness: 300000, free_length: 0.3717}, \
         damper: {type: linear, coefficient: 20000}}]}",
    );
    let steered = AxleKinematics::solve(&within(a.clone(), [-0.04, 0.04])).unwrap();
    steer(&steered, &[(1.0, 45.0722, 43.8517), (-1.0, -43.8517, -45.0722)], 0.01);
    let a = unsteered(a);
    let k = AxleKinematics::solve(&a).unwrap();
    follow(
        &k,
        &[
            (-0.1, 0.43365, 25.3679, 10.6564),
            (-0.04, 0.39636, 8.2625, 4.556),
            (0.0, 0.37165, 0.0, 0.0),
            (0.06, 0.33375, -9.1241, -6.8029),
            (0.1, 0.30766, -13.0917, -11.2443),
        ],
    );
    let samples = k.sample(&a.suspension, Motion::Parallel, 11, 1);
    for (travel, force) in [(-0.1_f64, -11834.3), (-0.04, -4553.3), (0.02, 2360.8), (0.1, 12706.7)] {
        let s = samples.iter().find(|s| (s.travel - travel).abs() < 1e-9).unwrap();
        assert!((s.force - force).abs() < 0.002 * f64::abs(force) + 2.0, "{travel}: {} {force}", s.force);
    }
    // Motion ratio and wheel rate at the static travel.
    let p = at(&k, Side::Left, 0.013_757_265_8, 0.0);
    assert!((-p.strut_rates[0] - 0.625_582).abs() < 2e-4, "{}", p.strut_rates[0]);
}

/// feda.yaml, front: struts on the lower arm; the fork's rack and the upstream pitman arm at 27.05 deg.
#[test]
fn a_double_wishbone_with_its_strut_on_the_arm_moves_as_the_fed_alphas_sheet_says() {
    let text = "{linkage: {type: double_wishbone, spindle: [0, 0.97663, 0], upper_arm_front: [0.0478, 0.2324, 0.3469], \
         upper_arm_rear: [-0.3215, 0.2324, 0.3469], upper_ball_joint: [-0.01759, 0.6744, 0.30589], \
         lower_arm_front: [0.16781, 0.2245, -0.08], lower_arm_rear: [-0.45219, 0.22245, -0.119], \
         lower_ball_joint: [0.00789, 0.80719, -0.13904], tie_rod_inner: [-0.24078, 0.379095, 0.04], \
         tie_rod_outer: [-0.207, 0.82618, 0]}, range: [-0.2, 0.17], \
         struts: [{chassis: [0.09397, 0.493925, 0.46209], end: [0.09397, 0.65153, -0.119], part: arm, \
         spring: {type: linear, stiffness: 76000, free_length: 0.60208}}]}";
    let rack = axle("steering: {type: rack_and_pinion, travel: 0.0872664626},", text);
    let k = AxleKinematics::solve(&rack).unwrap();
    follow(
        &k,
        &[
            (-0.2, 0.74165, 4.7425, -2.4255),
            (-0.1075, 0.67639, 1.1865, -0.5873),
            (0.0775, 0.54802, 0.2057, -0.1096),
            (0.17, 0.48212, 1.4215, -0.7154),
        ],
    );
    steer(&k, &[(1.0, 23.863, 25.534), (-1.0, -25.534, -23.863)], 0.01);
    let pitman = axle(
        "steering: {type: pitman_arm, pivot: [-0.49078, 0.379095, 0], arm_end: [-0.24078, 0.379095, 0], \
         idler_pivot: [-0.49078, -0.379095, 0], idler_end: [-0.24078, -0.379095, 0], angle: 0.472111563},",
        text,
    );
    let k = AxleKinematics::solve(&pitman).unwrap();
    let left = |command: f64| toe(&at(&k, Side::Left, 0.0, command));
    assert!((left(1.0) - 32.127).abs() < 0.01 && (left(-1.0) + 31.622).abs() < 0.01, "{}", left(1.0));
}

/// artcar.yaml, front: pitman arm parallelogram, 0.512 rad.
#[test]
fn a_pitman_arm_steers_as_the_artcars_sheet_says() {
    let a = axle(
        "steering: {type: pitman_arm, pivot: [0.09163, 0.01632, -0.03162], arm_end: [0.1128, 0.01632, -0.03162], \
         idler_pivot: [0.09163, -0.01632, -0.03162], idler_end: [0.1128, -0.01632, -0.03162], angle: 0.512},",
        "{linkage: {type: double_wishbone, spindle: [0.1426, 0.16599, -0.03725], \
         upper_arm_front: [0.17134, 0.0235, 0], upper_arm_rear: [0.12334, 0.0235, 0], \
         upper_ball_joint: [0.14424, 0.15348, -0.01169], lower_arm_front: [0.16547, 0.01998, -0.039], \
         lower_arm_rear: [0.10948, 0.01998, -0.039], lower_ball_joint: [0.14224, 0.15744, -0.05599], \
         tie_rod_inner: [0.1155, 0.033, -0.027], tie_rod_outer: [0.11716, 0.14677, -0.041]}, \
         range: [-0.05, 0.05], struts: [{chassis: [0.1421, 0.03108, 0.07157], end: [0.15318, 0.098, -0.043], \
         part: arm, spring: {type: linear, stiffness: 8000, free_length: 0.1363}}]}",
    );
    let k = AxleKinematics::solve(&within(a.clone(), [-0.025, 0.025])).unwrap();
    steer(&k, &[(1.0, 28.621, 22.265), (-1.0, -22.265, -28.621)], 0.01);
    let k = AxleKinematics::solve(&unsteered(a)).unwrap();
    follow(
        &k,
        &[(-0.05, 0.15563, 6.433, 1.4162), (0.025, 0.12101, 0.302, -1.2466), (0.05, 0.108, 2.2927, -2.9228)],
    );
}

/// man5t.yaml, front axle: three-link beam, rotary arm of 28.37 deg, drag link, bellcrank on the beam.
fn man_front() -> Axle {
    axle(
        "steering: {type: rotary_arm, pivot: [0.85, -0.028, 0.166], angle: 0.4951499},",
        "{linkage: {type: solid_axle, spindle: [0, 1.033, 0], beam: {mass: 405, inertia: 21.23}, \
         links: [{chassis: [0.871, 0.42, 0.165], carrier: [0.125, 0, 0.26]}, \
         {chassis: [-1.138, 0.27, 0.115], carrier: [-0.115, 0.49, -0.09]}], \
         knuckles: {kingpin_lower: [0, 0.853748866, -0.1], kingpin_upper: [0, 0.836251134, 0.1], \
         tie_rod: [-0.236, 0.8, 0.153], drag_link_inner: [0.741, -0.217, 0.089], \
         by: {type: bellcrank, pivot: [-0.023, 0, 0.25], axis: [0, 0, 1], drag_link_outer: [0.045, 0.256, 0.153], \
         tie_rod_left: [-0.273, 0.042, 0.153], tie_rod_right: [-0.273, -0.042, 0.153]}}}, \
         range: [-0.2, 0.2], struts: [\
         {chassis: [0.01, 0.552, 0.588], end: [0, 0.59, 0.09], part: beam, \
         spring: {type: progressive, stiffness: 85490, progression: 495208, free_length: 0.667}, \
         stops: {shortest: 0.335, longest: 0.630919952, table: [[0, 0], [0.002, 200], [0.004, 400], [0.006, 600], \
         [0.008, 800], [0.01, 1000], [0.02, 2500], [0.03, 4500], [0.04, 7500], [0.05, 12500]]}}, \
         {chassis: [0.235, 0.562, 0.57], end: [0.246, 0.523, -0.125], part: beam, \
         damper: {type: degressive, compression: 52526.6, compression_degression: 3, rebound: 98727.9, \
         rebound_degression: 4.77954}}]}",
    )
}

#[test]
fn a_three_link_beam_moves_and_is_sprung_as_the_trucks_sheet_says() {
    let a = unsteered(man_front());
    let k = AxleKinematics::solve(&a).unwrap();
    let samples = k.sample(&a.suspension, Motion::Parallel, 11, 1);
    // Travel, spring, shock, wheel force, fore-aft shift of the axle.
    for (travel, spring, shock, force, shift) in [
        (-0.16_f64, 0.6604, 0.88422, -3866.9, -0.03087),
        (-0.08, 0.57972, 0.78464, 11283.5, -0.01507),
        (0.0, 0.49955, 0.69618, 28205.4, 0.0),
        (0.08, 0.41974, 0.61781, 51112.9, 0.0133),
        (0.16, 0.34072, 0.5489, 78937.0, 0.02382),
        (0.2, 0.3018, 0.51777, 99308.8, 0.02761),
    ] {
        let s = samples.iter().find(|s| (s.travel - travel).abs() < 1e-9).unwrap();
        assert!((s.struts[0] - spring).abs() < 2e-5 && (s.struts[1] - shock).abs() < 2e-5, "{travel}");
        assert!((s.force - force).abs() < 2e-3 * force.abs() + 20.0, "{travel}: {} {force}", s.force);
        assert!((s.hub.x - shift).abs() < 2e-4, "{travel}: {} {shift}", s.hub.x);
    }
    // Roll stiffness and roll steer at the static travel, −0.02799 m.
    let rest = -0.027_986_647_5;
    let rolled = |d: f64| {
        let t = [rest + d, rest - d];
        let (l, r) = (k.wheel(Side::Left, t, 0.0), k.wheel(Side::Right, t, 0.0));
        let roll = asin((l.hub.z - r.hub.z) / (l.hub - r.hub).norm());
        (l, r, roll)
    };
    let (l, r, roll) = rolled(1e-3);
    let middle = 0.5 * (l.hub + r.hub);
    let centre = middle.y / sin(roll);
    assert!((centre - 0.267_446).abs() < 2e-3, "roll centre above the axle: {centre}");
    let beam = l.hub - r.hub;
    let yaw = atan2(-beam.x, beam.y);
    assert!(((yaw / roll).abs() - 0.067_357).abs() < 2e-3, "roll steer: {}", yaw / roll);
}

#[test]
fn a_bellcrank_on_the_beam_steers_as_the_trucks_sheet_says() {
    let k = AxleKinematics::solve(&man_front()).unwrap();
    steer(&k, &[(1.0, 31.3178, 26.0319), (-1.0, -22.5105, -26.1838)], 0.02);
}

/// m113.yaml: arm, torsion bar and shock of a road wheel.
#[test]
fn a_torsion_arm_carries_what_the_m113s_sheet_says() {
    let a = axle(
        "",
        "{linkage: {type: torsion_arm, spindle: [0, -0.12, 0], pivot: [0.288, -0.12, 0.134], axis: [0, 1, 0], \
         torsion: {stiffness: 25000, damping: 500, preload: 10000}}, range: [-0.12, 0.25], \
         struts: [{chassis: [-0.3, -0.12, 0.3], end: [0.184, -0.12, -0.106], part: arm, \
         damper: {type: linear, coefficient: 100}}]}",
    );
    let k = AxleKinematics::solve(&a).unwrap();
    for (angle, travel, force) in [
        (-0.3, -0.07912, 10614.0),
        (-0.1, -0.02808, 27454.1),
        (0.0, 0.0, 34722.2),
        (0.2, 0.05989, 48562.4),
        (0.5, 0.15448, 70980.9),
        (0.8, 0.24724, 101_085.9),
    ] {
        let p = at(&k, Side::Left, travel, 0.0);
        assert!((-p.struts[0] - angle).abs() < 1e-4, "{travel}: {} {angle}", p.struts[0]);
        let torque = 10000.0 - 25000.0 * p.struts[0];
        assert!((-torque * p.strut_rates[0] / force - 1.0).abs() < 2e-3, "{travel}: {force}");
    }
}

/// verti4wheeler.yaml, front: the same mechanism at a tenth of the size, steered further. The sheet rounds its points to
/// 0.1 mm on arms of 23 mm.
#[test]
fn the_small_cars_beam_steers_as_the_verti_4_wheelers_sheet_says() {
    let a = axle(
        "steering: {type: rotary_arm, pivot: [0.017, -0.0028, 0.0286], axis: [0, 0, -1], angle: 0.7853981634},",
        "{linkage: {type: solid_axle, spindle: [0, 0.1, 0], beam: {mass: 0.01125, inertia: 5.9e-5}, \
         links: [{chassis: [0.0845, 0.0406, 0.016], carrier: [0.0121, 0, 0.0252]}, \
         {chassis: [-0.1102, 0.0261, 0.0111], carrier: [-0.0111, 0.0474, -0.0087]}], \
         knuckles: {kingpin_lower: [0, 0.0826, -0.0097], kingpin_upper: [0, 0.081, 0.0097], \
         tie_rod: [-0.0228, 0.0774, 0.0148], drag_link_inner: [0.0718, -0.021, 0.0086], \
         by: {type: bellcrank, pivot: [-0.0022, 0, 0.0242], axis: [0, 0, 1], \
         drag_link_outer: [0.0044, 0.0248, 0.0148], tie_rod_left: [-0.0264, 0.0041, 0.0148], \
         tie_rod_right: [-0.0264, -0.0041, 0.0148]}}}, range: [-0.02, 0.01], \
         struts: [{chassis: [0.001, 0.0535, 0.0569], end: [0, 0.0571, 0.0087], part: beam, \
         spring: {type: progressive, stiffness: 2745, progression: 1372.5, free_length: 0.07}}]}",
    );
    let k = AxleKinematics::solve(&a).unwrap();
    steer(
        &k,
        &[
            (-1.0, -19.965, -22.805),
            (-0.5, -12.699, -13.739),
            (0.25, 8.772, 8.342),
            (0.5, 19.633, 17.525),
            (0.75, 33.568, 27.353),
            (1.0, 56.0, 37.418),
        ],
        0.1,
    );
}

/// verti4wheeler.yaml, rear: rods and triangle end on the line of the wheel centres, whose lengths conflict in heave. The
/// sheet advises an axle that rolls only.
#[test]
fn the_small_cars_rear_axle_locks_in_heave_and_pivots_instead() {
    let rods = axle(
        "",
        "{linkage: {type: solid_axle, spindle: [0, 0.1, 0], beam: {mass: 0.709, inertia: 0.005}, \
         links: [{chassis: [0.1, 0.026, 0.03], carrier: [0.0015, 0, 0]}, \
         {chassis: [0.1, 0.03, 0.05], carrier: [0, 0.06, 0]}]}, range: [-0.01, 0.01], \
         struts: [{chassis: [0, 0.04, 0.08], end: [0.01, 0.055, 0.005], part: beam, \
         spring: {type: linear, stiffness: 2.745, free_length: 0.06}}]}",
    );
    let e = AxleKinematics::solve(&rods).unwrap_err();
    assert!(matches!(e, LinkageError::BeamLocked { .. }), "{e}");
    let pivot = axle(
        "",
        "{linkage: {type: pivot_axle, spindle: [0, 0.1, 0], beam: {mass: 0.709, inertia: 0.005}, \
         pin_height: 0}, range: [-0.03, 0.03]}",
    );
    let k = AxleKinematics::solve(&pivot).unwrap();
    let travels = [0.03, -0.03];
    let (l, r) = (k.wheel(Side::Left, travels, 0.0), k.wheel(Side::Right, travels, 0.0));
    assert!((l.hub + r.hub).norm() < 1e-9, "the pin stays: {} {}", l.hub, r.hub);
    // 0.1 m of half track, 0.03 m up: asin 0.3.
    assert!((camber(&l) + degrees(asin(0.3))).abs() < 1e-3, "{}", camber(&l));
}
