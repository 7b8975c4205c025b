//! The data of an axle, and what suspensions of all templates share.

use super::json::Node;
use crate::ImportError;
use crate::place::middle;
use vb_vehicle::Point;
use vb_vehicle::suspension::{AntiRoll, Linkage, Part, Rod, Strut};

/// The length of the rods that stand for a ball joint or a slide, m.
const ROD: f64 = 0.3;

/// The data of an axle in a suspension file. Points are relative to the suspension's reference point.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    pub(crate) linkage: Linkage,
    pub(crate) struts: Vec<Strut>,
    /// Mass that moves with each wheel, without wheel and tyre, and without a beam, kg.
    pub(crate) unsprung: f64,
    /// Inertia of spindle and axle shaft about the wheel's axis, kg m².
    pub(crate) spin: f64,
    /// Masses that move with the chassis.
    pub(crate) sprung: Vec<(f64, Point)>,
    pub(crate) anti_roll: Option<AntiRoll>,
    /// The part to which an anti-roll bar is linked.
    pub(crate) bar: Option<Part>,
    /// Whether the drag link is the mirror image of the source's, so that its steering gear must be, too.
    pub(crate) mirrored: bool,
}

/// The spindle's place, its mass, and the spin inertia of spindle and axle shaft.
pub(super) fn spindle(root: &Node) -> Result<(Point, f64, f64), ImportError> {
    let node = root.need("Spindle")?;
    let at = node.pt("COM")?;
    if at[1] <= 0.0 {
        return node.fail(format!(
            "COM is at y = {}; points are those of the left side, where y is positive",
            at[1]
        ));
    }
    let shaft = root.get("Axle").map_or(Ok(0.0), |a| a.num_or("Inertia", 0.0))?;
    Ok((at, node.num("Mass")?, node.pt("Inertia")?[1] + shaft))
}

/// Half of a link's mass moves with the wheel and half with the chassis, at both sides.
pub(super) fn half(link: &Node, chassis: &[Point], parts: &mut Parts) -> Result<(), ImportError> {
    let Some(mass) = link.get("Mass") else { return Ok(()) };
    let mass = mass.number()?;
    parts.unsprung += 0.5 * mass;
    let [x, y, z] = middle(chassis);
    parts.sprung.push((0.5 * mass, [x, y, z]));
    parts.sprung.push((0.5 * mass, [x, -y, z]));
    Ok(())
}

pub(super) fn parts(
    linkage: Linkage,
    struts: Vec<Strut>,
    unsprung: f64,
    spin: f64,
    bar: Option<Part>,
) -> Parts {
    Parts { linkage, struts, unsprung, spin, sprung: Vec::new(), anti_roll: None, bar, mirrored: false }
}

/// Rods that hold a point of a part at a point of the chassis.
pub(super) fn ball(at: Point, signs: Point) -> [Rod; 3] {
    std::array::from_fn(|k| {
        let mut chassis = at;
        chassis[k] += ROD * signs[k];
        Rod { chassis, carrier: at }
    })
}
