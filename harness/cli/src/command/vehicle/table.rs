//! What a vehicle is made of, as a table and for programs.

use serde::Serialize;
use vb_page::rounded;
use vb_trial::planner_vehicle;
use vb_validate::{Characteristics, Ride};
use vb_vehicle::{
    powertrain::{Converter, Engine},
    suspension::SteeringGear,
};

use super::standing::Standing;
use crate::command::list::scale;
use crate::output;

/// The specification of a vehicle. SI units, angles in degrees.
#[derive(Debug, Serialize)]
pub(super) struct Specification {
    name: String,
    description: String,
    /// Of the worlds that it is made for.
    scale: f64,
    /// Overall, mirrors and all that touches nothing included.
    length_m: f64,
    width_m: f64,
    height_m: f64,
    /// Of hull and tyres, which collide: what planners are told.
    collision_length_m: f64,
    collision_width_m: f64,
    collision_height_m: f64,
    mass_kg: f64,
    sprung_mass_kg: f64,
    wheelbase_m: f64,
    track_m: f64,
    /// Of the hull, standing.
    ground_clearance_m: f64,
    /// SAE J1100; at most 90.
    approach_angle_deg: f64,
    departure_angle_deg: f64,
    /// None where the hull is in no ramp's way.
    break_over_angle_deg: Option<f64>,
    /// Of the reference point, without slip.
    turning_radius_m: f64,
    /// The distance of the sides at which wheels without slip would turn as fast at full command. With skid steering on wheels.
    effective_track_m: Option<f64>,
    /// In place at full command. With skid steering on wheels.
    turning_in_place_rad_per_s: Option<f64>,
    /// Of the middle of the outer front wheel, without slip. None on tracks.
    outer_front_wheel_radius_m: Option<f64>,
    /// The height of the ground under one front wheel at which another wheel lifts.
    articulation_m: Option<f64>,
    /// Of blocks under two wheels diagonally across from each other.
    diagonal_articulation_m: Option<f64>,
    roll_gradient_deg_per_g: Option<f64>,
    max_speed_m_per_s: f64,
    /// Sprung, in the chassis frame.
    centre_of_mass_m: [f64; 3],
    inertia_kg_m2: [f64; 3],
    axles: Vec<AxleRow>,
    tyres: Vec<String>,
    engine: String,
    gears: Vec<f64>,
    /// None without one.
    reverse_gear: Option<f64>,
    /// Below which a direction opposed to the motion can be put in.
    direction_change_speed_m_per_s: f64,
    direction_change_latency_s: f64,
    centre_differential: &'static str,
    deviations: Vec<String>,
}

#[derive(Debug, Serialize)]
struct AxleRow {
    name: String,
    x_m: f64,
    suspension: &'static str,
    /// From the lowest to the highest travel, mm.
    travel_mm: [f64; 2],
    steering: Option<&'static str>,
    /// Of the left and right wheel at the left lock.
    wheel_angles_deg: Option<[f64; 2]>,
    driven: bool,
    differential: Option<&'static str>,
    unsprung_mass_kg: f64,
    brake_torque_n_m: f64,
    tyre: String,
    load_n: f64,
    /// None for wheels that are fixed to the chassis.
    ride: Option<Ride>,
}

fn engine(engine: &Engine, converter: Option<&Converter>) -> String {
    let best = |points: &[[f64; 2]]| {
        let torque = points.iter().map(|p| p[1]).fold(0.0, f64::max);
        // Straight lines between points: the greatest power lies at a point or between two.
        let power = points.windows(2).flat_map(|w| {
            (0..=100).map(move |k| {
                let f = f64::from(k) / 100.0;
                (w[0][0] + f * (w[1][0] - w[0][0])) * (w[0][1] + f * (w[1][1] - w[0][1]))
            })
        });
        (torque, power.fold(0.0, f64::max))
    };
    let (kind, (torque, power)) = match engine {
        Engine::Map { full_throttle, .. } => ("torque map", best(full_throttle)),
        Engine::Simple { torque, power, .. } => ("constant torque, constant power", (*torque, *power)),
        Engine::Electric { torque, .. } => ("electric motor", best(torque)),
    };
    let unit =
        if power < 1e3 { format!("{} W", rounded(power)) } else { format!("{} kW", rounded(power / 1e3)) };
    let behind = if converter.is_some() { ", torque converter" } else { "" };
    format!("{kind}, {} N m, {unit}{behind}", rounded(torque))
}

impl Specification {
    pub(super) fn new(standing: &Standing, characteristics: Characteristics) -> Self {
        let c = characteristics;
        let v = &standing.spec;
        let told = planner_vehicle(v, &standing.shape, v.scale);
        let (line, gearbox) = (&v.powertrain.driveline, &v.powertrain.gearbox);
        let mut driven = line.axles.iter();
        let tyre = |t: &vb_vehicle::TyreSpec| {
            format!("{}, radius {} m, width {} m", t.model(), rounded(t.radius()), rounded(t.width()))
        };
        let axles = v.axles.iter().enumerate().map(|(i, a)| {
            let angles = a.steering.as_ref().and_then(|_| {
                let solved = vb_vehicle::kinematics::AxleKinematics::solve(a).ok()?;
                Some([vb_vehicle::kinematics::Side::Left, vb_vehicle::kinematics::Side::Right].map(|side| {
                    let axis = solved.wheel(side, [0.0; 2], 1.0).axis;
                    vb_math::angle::degrees(vb_math::atan2(-axis.x, axis.y))
                }))
            });
            let own = driven_axle(a.driven, &mut driven);
            AxleRow {
                name: a.name.clone(),
                x_m: a.position[0] + a.suspension.linkage.spindle()[0],
                suspension: a.suspension.linkage.kind(),
                travel_mm: a.suspension.range.map(|t| 1e3 * t),
                steering: a.steering.as_ref().map(SteeringGear::kind),
                wheel_angles_deg: angles,
                driven: a.driven,
                differential: own.map(|d| d.differential.kind()),
                unsprung_mass_kg: 2.0 * a.unsprung_mass + a.suspension.linkage.beam().map_or(0.0, |b| b.mass),
                brake_torque_n_m: 2.0 * a.brake_torque,
                tyre: tyre(v.tyre_of(a)),
                load_n: standing.state.wheels[2 * i..2 * i + 2].iter().map(|w| w.load).sum(),
                ride: c.axles[i].ride,
            }
        });
        let mut tyres: Vec<String> = v.tyres.keys().cloned().collect();
        tyres.insert(0, v.tyre.model().to_owned());
        Self {
            name: v.name.clone(),
            description: v.description.clone(),
            scale: v.scale,
            length_m: v.length,
            width_m: v.width,
            height_m: v.height,
            collision_length_m: told.length,
            collision_width_m: told.width,
            collision_height_m: told.height,
            mass_kg: v.total_mass(),
            sprung_mass_kg: v.chassis.mass,
            wheelbase_m: told.wheelbase,
            track_m: told.track,
            ground_clearance_m: told.ground_clearance,
            approach_angle_deg: c.approach_angle_deg,
            departure_angle_deg: c.departure_angle_deg,
            break_over_angle_deg: c.break_over_angle_deg,
            turning_radius_m: told.min_turn_radius,
            effective_track_m: standing.shape.skid.map(|s| s.effective_track),
            turning_in_place_rad_per_s: standing.shape.skid.map(|s| s.in_place),
            outer_front_wheel_radius_m: c.outer_front_wheel_radius_m,
            articulation_m: c.articulation_m,
            diagonal_articulation_m: c.diagonal_articulation_m,
            roll_gradient_deg_per_g: c.roll_gradient_deg_per_g,
            max_speed_m_per_s: v.max_speed,
            centre_of_mass_m: v.chassis.com,
            inertia_kg_m2: v.chassis.inertia,
            axles: axles.collect(),
            tyres,
            engine: engine(&v.powertrain.engine, v.powertrain.converter.as_ref()),
            gears: gearbox.ratios.clone(),
            reverse_gear: gearbox.reverse,
            direction_change_speed_m_per_s: gearbox.direction_change.speed,
            direction_change_latency_s: gearbox.direction_change.latency,
            centre_differential: if line.axles.len() > 1 { line.centre.kind() } else { "none" },
            deviations: v.deviations.clone(),
        }
    }

    /// The table for people.
    pub(super) fn text(&self) -> String {
        let mut rows: Vec<Vec<String>> = Vec::new();
        let mut row = |name: &str, value: String| rows.push(vec![name.to_owned(), value]);
        let m = |v: f64| format!("{} m", rounded(v));
        let triple = |v: [f64; 3]| v.map(rounded).join(", ");
        row("name", self.name.clone());
        row("description", self.description.clone());
        row("world scale", scale(self.scale));
        let box_of = |sides: [f64; 3]| sides.map(m).join(" x ");
        row("length x width x height", box_of([self.length_m, self.width_m, self.height_m]));
        let collides = [self.collision_length_m, self.collision_width_m, self.collision_height_m];
        row("of hull and tyres", format!("{} (reported to planners)", box_of(collides)));
        row("mass", format!("{:.1} kg, of which {:.1} kg sprung", self.mass_kg, self.sprung_mass_kg));
        row("wheelbase, track", format!("{}, {}", m(self.wheelbase_m), m(self.track_m)));
        row("ground clearance", format!("{} (hull)", m(self.ground_clearance_m)));
        let ramp =
            |angle: f64| if angle < 90.0 { format!("{angle:.1}°") } else { "90° or more".to_owned() };
        let mut angles =
            format!("{} in front, {} behind", ramp(self.approach_angle_deg), ramp(self.departure_angle_deg));
        if let Some(between) = self.break_over_angle_deg {
            angles += &format!(", break-over {between:.1}°");
        }
        row("approach, departure", angles);
        let slip = if self.effective_track_m.is_some() { "driving at full command" } else { "no slip" };
        let mut turning = format!("{} (reference point, {slip})", m(self.turning_radius_m));
        if let Some(outer) = self.outer_front_wheel_radius_m {
            turning += &format!(", {outer:.2} m (outer front wheel)");
        }
        row("turning radius", turning);
        if let (Some(track), Some(rate)) = (self.effective_track_m, self.turning_in_place_rad_per_s) {
            row("effective track", format!("{} (driving at full command)", m(track)));
            row("turning in place", format!("{} rad/s", rounded(rate)));
        }
        if let Some(gradient) = self.roll_gradient_deg_per_g {
            row("roll gradient", format!("{gradient:.2} °/g (suspensions and tyres)"));
        }
        if let (Some(one), Some(two)) = (self.articulation_m, self.diagonal_articulation_m) {
            let text = format!(
                "{one:.3} m under one front wheel lifts another, {two:.3} m under two diagonal wheels"
            );
            row("articulation", text);
        }
        row("top speed", format!("{} m/s", rounded(self.max_speed_m_per_s)));
        row("centre of sprung mass", format!("{} m", triple(self.centre_of_mass_m)));
        row("sprung inertia", format!("{} kg m²", triple(self.inertia_kg_m2)));
        for a in &self.axles {
            let mut words = vec![format!("x {}", m(a.x_m)), a.suspension.to_owned()];
            if a.travel_mm != [0.0; 2] {
                words.push(format!("travel {} to {} mm", rounded(a.travel_mm[0]), rounded(a.travel_mm[1])));
            }
            if let (Some(gear), Some([l, r])) = (a.steering, a.wheel_angles_deg) {
                words.push(format!("{gear} to {l:.1}° and {r:.1}°"));
            }
            match a.differential {
                Some(d) => words.push(format!("driven, {d} differential")),
                None => words.push("not driven".to_owned()),
            }
            words.push(format!("{} kg unsprung", rounded(a.unsprung_mass_kg)));
            words.push(format!("brakes {} N m", rounded(a.brake_torque_n_m)));
            words.push(format!("load {} N", rounded(a.load_n)));
            row(&format!("axle {}", a.name), words.join(", "));
        }
        for a in &self.axles {
            let Some(ride) = a.ride else { continue };
            let [jounce, rebound] = ride.damping_ratio;
            let text = format!(
                "{:.2} Hz ({:.2} Hz with tyres), wheel rate {:.3} kN/m, damping ratio {jounce:.2} in jounce, {rebound:.2} in rebound",
                ride.ride_frequency_hz,
                ride.frequency_with_tyre_hz,
                1e-3 * ride.wheel_rate_n_per_m
            );
            row(&format!("ride {}", a.name), text);
        }
        let mut different: Vec<&str> = self.axles.iter().map(|a| a.tyre.as_str()).collect();
        different.dedup();
        row("tyre", different.join("; "));
        row("available tyres", self.tyres.join(", "));
        row("engine", self.engine.clone());
        row("gears", self.gears.iter().map(|g| rounded(*g)).collect::<Vec<_>>().join(", "));
        let change = format!(
            "engages below {} m/s within {} s",
            rounded(self.direction_change_speed_m_per_s),
            rounded(self.direction_change_latency_s)
        );
        row(
            "reverse gear",
            self.reverse_gear.map_or("none".to_owned(), |r| format!("{}, {change}", rounded(r))),
        );
        row("centre differential", self.centre_differential.to_owned());
        for (i, d) in self.deviations.iter().enumerate() {
            row(if i == 0 { "deviations" } else { "" }, format!("- {d}"));
        }
        output::columns(&rows)
    }
}

fn driven_axle<'a>(
    driven: bool,
    axles: &mut std::slice::Iter<'a, vb_vehicle::powertrain::DrivenAxle>,
) -> Option<&'a vb_vehicle::powertrain::DrivenAxle> {
    if driven { axles.next() } else { None }
}
