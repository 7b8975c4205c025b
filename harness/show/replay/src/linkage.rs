//! The bars between chassis and wheels, as a vehicle's file has them, for a page that moves them with the wheels.
//!
//! A *carrier* is what carries a wheel, or two: an upright, an arm, or a beam. The page knows each wheel's centre and the direction
//! of its axle; what the carrier has turned about that direction follows from the rods, which keep their lengths, and from a pin,
//! which keeps its place. So the page needs no poses of carriers, and bars follow the wheels to a few millimetres.

use serde_json::{Value, json};
use vb_vehicle::suspension::{Linkage, Part, Rod, Suspension};
use vb_vehicle::{Axle, Point, VehicleSpec};

/// A bar between two points, in the chassis frame at design height, m.
type Bar = [Point; 2];

/// Points of one side or of both, moved to where the axle is, on the side that is drawn.
struct Place {
    at: Point,
    side: f64,
}

impl Place {
    fn point(&self, p: Point) -> Point {
        [self.at[0] + p[0], self.at[1] + self.side * p[1], self.at[2] + p[2]]
    }

    fn bar(&self, a: Point, b: Point) -> Bar {
        [self.point(a), self.point(b)]
    }

    fn rod(&self, rod: &Rod) -> Bar {
        self.bar(rod.chassis, rod.carrier)
    }
}

/// What carries wheels, with the bars at it.
#[derive(Default)]
struct Carrier {
    /// The wheels that it carries: one, or the left and the right one of a beam.
    wheels: Vec<usize>,
    /// Its centre: that of its wheel, or the middle between its wheels.
    centre: Point,
    /// Bars of constant length from the chassis to the carrier.
    rods: Vec<Bar>,
    /// A tie rod, whose inner end the steering moves sideways, to its outer end on the carrier.
    tie: Option<Bar>,
    /// A point of the carrier that is fixed to the chassis.
    pin: Option<Point>,
    /// Of a beam with knuckles: two points of the line about which each wheel turns on it.
    kingpins: Vec<Bar>,
    /// Bars on the carrier.
    spokes: Vec<Bar>,
    /// Springs and dampers from the chassis to the carrier.
    struts: Vec<Bar>,
    /// Springs and dampers from the chassis to the arm.
    arm_struts: Vec<Bar>,
    /// Two points of the axis about which the arm turns, and its tip, which is on the carrier too.
    arm: Option<[Point; 3]>,
}

impl Carrier {
    fn json(&self) -> Value {
        json!({
            "wheels": self.wheels, "centre": self.centre, "rods": self.rods, "tie": self.tie, "pin": self.pin,
            "kingpins": self.kingpins, "spokes": self.spokes, "struts": self.struts, "arm_struts": self.arm_struts, "arm": self.arm,
        })
    }
}

fn middle(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]))
}

/// The carrier of a wheel that is guided independently.
fn corner(suspension: &Suspension, place: &Place, wheel: usize) -> Carrier {
    let spindle = suspension.linkage.spindle();
    let mut c = Carrier { wheels: vec![wheel], centre: place.point(spindle), ..Carrier::default() };
    match &suspension.linkage {
        Linkage::DoubleWishbone(l) => {
            let (upper, lower) = (l.upper_ball_joint, l.lower_ball_joint);
            c.rods = vec![
                place.bar(l.lower_arm_front, lower),
                place.bar(l.lower_arm_rear, lower),
                place.bar(l.upper_arm_front, upper),
                place.bar(l.upper_arm_rear, upper),
            ];
            c.tie = Some(place.bar(l.tie_rod_inner, l.tie_rod_outer));
            c.spokes = vec![place.bar(lower, upper), place.bar(middle(lower, upper), spindle)];
            c.arm = Some([l.lower_arm_front, l.lower_arm_rear, lower].map(|p| place.point(p)));
        }
        Linkage::SingleWishbone(l) => {
            let (lower, upper) = (l.kingpin_lower, l.kingpin_upper);
            c.rods = vec![place.bar(l.arm_front, lower), place.bar(l.arm_rear, lower)];
            c.tie = Some(place.bar(l.tie_rod_inner, l.tie_rod_outer));
            c.spokes = vec![place.bar(lower, upper), place.bar(middle(lower, upper), spindle)];
            c.arm = Some([l.arm_front, l.arm_rear, lower].map(|p| place.point(p)));
        }
        Linkage::Multilink(l) => {
            c.rods = l.links.iter().map(|rod| place.rod(rod)).collect();
            c.tie = Some(place.bar(l.tie_rod_inner, l.tie_rod_outer));
            c.spokes = l.links.iter().map(|rod| place.bar(rod.carrier, spindle)).collect();
        }
        Linkage::TorsionArm(l) => {
            c.pin = Some(place.point(l.pivot));
            // Beside the hull, and then out to the wheel.
            c.spokes = vec![
                place.bar(l.pivot, [spindle[0], l.pivot[1], spindle[2]]),
                place.bar([spindle[0], l.pivot[1], spindle[2]], spindle),
            ];
        }
        Linkage::SolidAxle(_) | Linkage::LeafAxle(_) | Linkage::PivotAxle(_) | Linkage::Rigid(_) => {}
    }
    let own_arm = c.arm.is_some();
    for strut in &suspension.struts {
        let bar = place.bar(strut.chassis, strut.end);
        if strut.part == Part::Arm && own_arm { c.arm_struts.push(bar) } else { c.struts.push(bar) }
    }
    c
}

/// The beam between two wheels, or the axle of wheels without suspension.
fn beam(axle: &Axle, first: usize) -> Carrier {
    let suspension = &axle.suspension;
    let [left, right] = [1.0, -1.0].map(|side| Place { at: axle.position, side });
    let spindle = suspension.linkage.spindle();
    let mut c = Carrier {
        wheels: vec![first, first + 1],
        centre: middle(left.point(spindle), right.point(spindle)),
        spokes: vec![[left.point(spindle), right.point(spindle)]],
        ..Carrier::default()
    };
    let both = [&left, &right];
    match &suspension.linkage {
        Linkage::SolidAxle(l) => {
            c.rods = both.iter().flat_map(|place| l.links.iter().map(|rod| place.rod(rod))).collect();
            c.rods.extend(l.single_links.iter().map(|rod| left.rod(rod)));
        }
        Linkage::LeafAxle(l) => c.struts = both.iter().map(|place| place.bar(l.eye, l.seat)).collect(),
        Linkage::PivotAxle(l) => {
            let pin = [spindle[0], 0.0, l.pin_height];
            c.spokes.push([left.point(pin), c.centre]);
        }
        _ => {}
    }
    for place in both {
        c.kingpins.extend(suspension.linkage.knuckles().map(|k| place.bar(k.kingpin_lower, k.kingpin_upper)));
        c.struts.extend(suspension.struts.iter().map(|s| place.bar(s.chassis, s.end)));
    }
    c
}

/// The carriers of all wheels for the page.
pub(crate) fn carriers(spec: &VehicleSpec) -> Value {
    let axles = spec.axles.iter().enumerate().flat_map(|(a, axle)| match &axle.suspension.linkage {
        Linkage::SolidAxle(_) | Linkage::LeafAxle(_) | Linkage::PivotAxle(_) | Linkage::Rigid(_) => {
            vec![beam(axle, 2 * a)]
        }
        _ => [1.0, -1.0]
            .into_iter()
            .enumerate()
            .map(|(i, side)| corner(&axle.suspension, &Place { at: axle.position, side }, 2 * a + i))
            .collect(),
    });
    axles.map(|c| c.json()).collect()
}
