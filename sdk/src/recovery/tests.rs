use super::*;
use crate::{Pose2, Vec3, Wheel};

/// A bicycle with optional walls, and a gearbox that changes direction as specified by [`Vehicle`].
struct Bicycle {
    task: Task,
    time: f64,
    x: f64,
    y: f64,
    yaw: f64,
    v: f64,
    gear: Gear,
    /// The gear that is being engaged, and its time.
    coming: Option<(Gear, f64)>,
    /// Whether the reference point is blocked at a position.
    wall: fn(f64, f64) -> bool,
    wheels: f64,
    dt: f64,
}

impl Bicycle {
    fn new(scale: f64, wall: fn(f64, f64) -> bool) -> Self {
        let root = scale.sqrt();
        let vehicle = Vehicle {
            scale,
            length: 4.5 * scale,
            wheelbase: 3.3 * scale,
            wheel_radius: 0.5 * scale,
            max_steer_angle: 0.5,
            max_speed: 20.0 * root,
            max_reverse_speed: 5.0 * root,
            direction_change_speed: 0.5 * root,
            direction_change_time: 0.6 * root,
            ..Vehicle::default()
        };
        let half_extent = Point2 { x: 64.0 * scale, y: 64.0 * scale };
        let task = Task { vehicle, half_extent, start: Pose2::default(), ..Task::default() };
        let (x, y, yaw, v, time, wheels) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        let (gear, coming) = (Gear::Forward, None);
        Self { task, time, x, y, yaw, v, gear, coming, wall, wheels, dt: 0.125 * root }
    }

    fn helper(&self, settings: &Settings) -> Recovery {
        Recovery::new(&self.task, settings.scaled(self.task.vehicle.scale))
    }

    fn look(&self) -> Observation {
        let position = Vec3 { x: self.x, y: self.y, z: 0.0 };
        let linear_velocity = Vec3 { x: self.v, y: 0.0, z: 0.0 };
        let spin = self.wheels / self.task.vehicle.wheel_radius;
        Observation {
            time: self.time,
            wheels: vec![Wheel { spin, travel: 0.0 }; 4],
            gear: self.gear,
            ..Observation::of(Pose { position, yaw: self.yaw, linear_velocity, ..Pose::default() })
        }
    }

    fn drive(&mut self, c: &Command) {
        let vehicle = &self.task.vehicle;
        let aim = self.coming.map_or(self.gear, |(gear, _)| gear);
        if c.gear != aim && self.v.abs() < vehicle.direction_change_speed {
            self.coming = Some((c.gear, self.time + vehicle.direction_change_time));
            self.gear = Gear::Neutral;
        }
        if let Some((gear, when)) = self.coming
            && self.time >= when
        {
            (self.gear, self.coming) = (gear, None);
        }
        let pull = match self.gear {
            Gear::Forward => c.throttle,
            Gear::Neutral => 0.0,
            Gear::Reverse => -c.throttle,
        };
        let root = vehicle.scale.sqrt();
        let v = self.v + self.dt * (3.0 * pull - 0.25 * self.v / root);
        let slower = self.dt * 6.0 * c.brake;
        self.v = if v.abs() < slower { 0.0 } else { v - slower * v.signum() };
        self.time += self.dt;
        let (sin, cos) = math::sin_cos(self.yaw);
        let (x, y) = (self.x + self.dt * self.v * cos, self.y + self.dt * self.v * sin);
        self.wheels = self.v;
        if (self.wall)(x, y) {
            (self.v, self.wheels) = (0.0, 10.0 * root * pull);
        } else {
            self.yaw +=
                self.dt * self.v * math::tan(c.steering * vehicle.max_steer_angle) / vehicle.wheelbase;
            (self.x, self.y) = (x, y);
        }
    }

    /// Simulates so many seconds at full scale. Returns observations and commands.
    fn trip(
        &mut self,
        r: &mut Recovery,
        seconds: f64,
        planner: impl Fn(&Self) -> Command,
    ) -> Vec<(Observation, Phase, Command)> {
        let steps = (seconds * self.task.vehicle.scale.sqrt() / self.dt) as u32;
        (0..steps)
            .map(|_| {
                let o = self.look();
                let command = r.update(&o, planner(self));
                self.drive(&command);
                (o, r.phase(), command)
            })
            .collect()
    }
}

fn ahead() -> Command {
    Command { throttle: 0.5, ..Command::default() }
}

fn place(o: &Observation) -> (f64, f64) {
    o.pose().map(|p| (p.position.x, p.position.y)).unwrap()
}

/// Lengths of all sections in reverse.
fn stretches(trip: &[(Observation, Phase, Command)]) -> Vec<f64> {
    trip.chunk_by(|a, b| a.1 == b.1)
        .filter(|c| c[0].1 == Phase::Back)
        .map(|c| {
            let (a, b) = (place(&c[0].0), place(&c[c.len() - 1].0));
            math::hypot(a.0 - b.0, a.1 - b.1)
        })
        .collect()
}

#[test]
fn a_vehicle_that_gets_on_is_driven_by_its_planner_bit_for_bit() {
    let mut b = Bicycle::new(1.0, |_, _| false);
    let mut r = b.helper(&Settings::default());
    for i in 0..2000u32 {
        let i = f64::from(i);
        let debug = vec![crate::Series { name: "i".into(), values: vec![i as f32] }];
        // Throttle and brake that occasionally slow the vehicle to a crawl.
        let (throttle, brake) = if i % 50.0 < 40.0 { (0.3, 0.0) } else { (0.0, 0.1) };
        let wanted = Command { steering: math::sin(0.1 * i), throttle, brake, gear: Gear::Forward, debug };
        let sent = r.update(&b.look(), wanted.clone());
        assert_eq!(sent, wanted);
        b.drive(&sent);
    }
    // Its memory is bounded.
    assert_eq!((r.history.len(), r.track.len()), (MARKS, TRACK));
}

#[test]
fn a_start_with_spinning_wheels_is_no_reason_to_back_out() {
    let mut b = Bicycle::new(1.0, |_, _| false);
    let mut r = b.helper(&Settings::default());
    for _ in 0..100 {
        b.wheels = 5.0 * b.v + 2.0;
        let sent = r.update(&b.look(), ahead());
        assert_eq!(sent, ahead());
        b.drive(&sent);
    }
}

#[test]
fn a_planner_that_stands_or_reverses_by_its_own_choice_is_left_alone() {
    let mut b = Bicycle::new(1.0, |_, _| true);
    for wanted in [
        Command { brake: 1.0, ..Command::default() },
        Command { throttle: 1.0, gear: Gear::Reverse, ..Command::default() },
        Command { throttle: 1.0, gear: Gear::Neutral, ..Command::default() },
    ] {
        let mut r = b.helper(&Settings::default());
        for (_, _, sent) in b.trip(&mut r, 30.0, |_| wanted.clone()) {
            assert_eq!(sent, wanted);
        }
    }
}

#[test]
fn a_blocked_vehicle_backs_out_and_comes_by_on_another_line() {
    // A post that blocks a vehicle on a straight path.
    let mut b = Bicycle::new(1.0, |x, y| (10.0..11.0).contains(&x) && y.abs() < 0.25);
    let mut r = b.helper(&Settings { offset: 0.5, ..Settings::default() });
    let trip = b.trip(&mut r, 30.0, |b| Command { steering: (-b.yaw).clamp(-1.0, 1.0), ..ahead() });
    assert_eq!(stretches(&trip).len(), 1);
    assert!(b.x > 25.0 && b.y > 0.25, "{} {}", b.x, b.y);
    // It has left the place, and the planner drives again.
    assert_eq!((r.phase(), r.attempts(), r.blocked()), (Phase::Drive, 0, None));
    assert_eq!(trip[trip.len() - 1].2.throttle, 0.5);
}

#[test]
fn it_backs_along_the_way_on_which_it_came() {
    // A circle of 8 m to the left.
    let mut b = Bicycle::new(1.0, |_, y| y > 8.0);
    let mut r = b.helper(&Settings { back: 6.0, swing: 0.0, ..Settings::default() });
    let steering = math::atan(3.3 / 8.0) / 0.5;
    let trip = b.trip(&mut r, 20.0, |_| Command { steering, ..ahead() });
    let first = trip.iter().position(|t| t.1 == Phase::Back).unwrap();
    let back: Vec<_> = trip[first..].iter().take_while(|t| t.1 == Phase::Back).collect();
    assert!(stretches(&trip)[0] > 5.0);
    for (o, ..) in back {
        let (x, y) = place(o);
        let off = math::hypot(x, y - 8.0) - 8.0;
        assert!(off.abs() < 0.3, "{off} m off the way at {x} {y}");
    }
}

#[test]
fn it_backs_farther_with_each_attempt_up_to_a_bound() {
    let mut b = Bicycle::new(1.0, |x, _| x > 30.0);
    let settings = Settings { back: 3.0, back_more: 1.0, back_most: 5.0, apart: 0.0, ..Settings::default() };
    let mut r = b.helper(&settings);
    let trip = b.trip(&mut r, 60.0, |_| ahead());
    let far = stretches(&trip);
    for (far, wanted) in far.iter().zip([3.0, 4.0, 5.0, 5.0]) {
        assert!((far - wanted).abs() < 0.5, "{far} in place of {wanted}");
    }
    assert!(far.len() >= 4);
}

#[test]
fn the_throttle_is_closed_until_the_wanted_direction_is_in() {
    let mut b = Bicycle::new(1.0, |x, _| x > 10.0);
    let mut r = b.helper(&Settings::default());
    let trip = b.trip(&mut r, 60.0, |_| ahead());
    assert!(trip.iter().any(|(o, ..)| o.gear == Gear::Reverse));
    for (o, _, sent) in trip {
        assert!(sent.throttle == 0.0 || o.gear == sent.gear, "{sent:?} in {:?}", o.gear);
    }
}

#[test]
fn it_comes_to_the_obstacle_again_before_the_rules_see_it_where_it_was() {
    let walls: [fn(f64, f64) -> bool; 4] =
        [|x, _| x > 5.0, |x, _| x > 10.0, |x, _| x > 20.0, |x, _| x > 30.0];
    for (i, wall) in walls.into_iter().enumerate() {
        let mut b = Bicycle::new(1.0, wall);
        let mut r = b.helper(&Settings::default());
        let trip = b.trip(&mut r, 60.0, |_| ahead());
        let second = trip.iter().position(|t| t.1 == Phase::Again).unwrap();
        let second = second + trip[second..].iter().position(|t| t.1 == Phase::Back).unwrap();
        for pair in trip[..second].windows(81) {
            let (now, then) = (place(&pair[80].0), place(&pair[0].0));
            let moved = math::hypot(now.0 - then.0, now.1 - then.1);
            assert!(moved > 1.0, "{moved} m at {} s before wall {i}", pair[80].0.time);
        }
    }
}

#[test]
fn it_stays_in_the_world() {
    // It cannot leave its start, close to the western edge.
    let mut b = Bicycle::new(1.0, |x, _| x > -58.0);
    b.x = -58.5;
    let mut r = b.helper(&Settings { margin: 1.0, ..Settings::default() });
    let trip = b.trip(&mut r, 30.0, |_| ahead());
    assert!(stretches(&trip)[0] > 1.0);
    for (o, ..) in trip {
        // Half of the length plus the stopping distance.
        assert!(place(&o).0 - 2.25 > -64.0, "{:?}", place(&o));
    }
}

#[test]
fn without_reverse_or_way_back_it_swings_its_wheels_to_both_sides() {
    for reverse in [0.0, 5.0] {
        let mut b = Bicycle::new(1.0, |_, _| true);
        b.task.vehicle.max_reverse_speed = reverse;
        let mut r = b.helper(&Settings::default());
        let trip = b.trip(&mut r, 20.0, |_| ahead());
        let forward =
            |side: f64| trip.iter().any(|(_, _, c)| c.gear == Gear::Forward && c.steering * side > 0.5);
        assert!(forward(1.0) && forward(-1.0));
        assert_eq!(trip.iter().any(|(_, _, c)| c.gear == Gear::Reverse), reverse > 0.0);
    }
}

#[test]
fn a_small_vehicle_does_the_same_by_froudes_rule() {
    let drive = |scale: f64, wall: fn(f64, f64) -> bool| {
        let mut b = Bicycle::new(scale, wall);
        let mut r = b.helper(&Settings::default());
        b.trip(&mut r, 60.0, |_| ahead())
    };
    // Powers of two for the scale and its root: identical bits.
    let (large, small) = (drive(1.0, |x, _| x > 16.0), drive(0.0625, |x, _| x > 1.0));
    assert!(large.len() == small.len() && stretches(&large).len() > 2);
    for ((o, phase, _), (p, same, _)) in large.iter().zip(&small) {
        let (a, b) = (place(o), place(p));
        assert!(phase == same && (a.0 - 16.0 * b.0).abs() < 1e-9 && (a.1 - 16.0 * b.1).abs() < 1e-9);
    }
}

#[test]
fn senseless_observations_do_no_harm() {
    let odd = [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e308, -1e308, 5e-324, 0.0, 1.0, -3.0];
    let mut b = Bicycle::new(1.0, |x, _| x > 10.0);
    let mut r = b.helper(&Settings::default());
    b.trip(&mut r, 8.0, |_| ahead());
    for i in 0..20_000usize {
        let v = |k: usize| odd[(i / k) % odd.len()];
        let mut o = b.look();
        o.time = if i % 3 == 0 { v(7) } else { 0.1 * i as f64 };
        o.gear = [Gear::Forward, Gear::Neutral, Gear::Reverse][(i / 100) % 3];
        o.pose = Some(Pose {
            position: Vec3 { x: v(1), y: v(2), z: v(3) },
            yaw: v(5),
            linear_velocity: Vec3 { x: v(11), y: 0.0, z: 0.0 },
            ..Pose::default()
        });
        o.wheels = vec![Wheel { spin: v(13), travel: 0.0 }; i % 5];
        if i % 17 == 0 {
            o.pose = None;
        }
        let c = r.update(&o, ahead());
        assert!([c.steering, c.throttle, c.brake].iter().all(|v| v.is_finite()), "{c:?}");
        assert!(r.history.len() <= MARKS && r.track.len() <= TRACK);
    }
}
