//! Links and joints of a robot.

use super::xacro::package;
use super::xml::Element;
use crate::hull;
use crate::place::{IDENTITY, Mass, Matrix, add, product, roll_pitch_yaw, transposed, turn};
use crate::{ImportError, Notes};
use std::collections::BTreeMap;
use std::path::Path;
use vb_vehicle::Point;

/// The most links of a robot.
const LINKS: usize = 2000;

/// A place and an orientation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    pub(super) at: Point,
    pub(super) axes: Matrix,
}

impl Pose {
    pub(super) const ORIGIN: Self = Self { at: [0.0; 3], axes: IDENTITY };

    /// The pose of `inner`, which is given in this one.
    pub(super) fn of(&self, inner: &Self) -> Self {
        Self { at: self.point(inner.at), axes: product(&self.axes, &inner.axes) }
    }

    pub(super) fn point(&self, p: Point) -> Point {
        add(self.at, turn(&self.axes, p))
    }

    /// The `<origin>` within an element; nothing means no offset.
    pub(super) fn read(e: &Element) -> Result<Self, ImportError> {
        match e.child("origin") {
            Some(o) => Ok(Self { at: o.triple("xyz")?, axes: roll_pitch_yaw(o.triple("rpy")?) }),
            None => Ok(Self::ORIGIN),
        }
    }
}

/// A shape as a point cloud in its link's frame.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    pub(super) points: Vec<Point>,
    /// Whether it is a ball, which has no width.
    pub(super) ball: bool,
}

/// A link.
#[derive(Clone, Debug)]
pub(super) struct Link {
    pub(super) name: String,
    /// Its body in its own frame.
    pub(super) mass: Mass,
    /// Whether the file gives an inertia.
    pub(super) massive: bool,
    /// Collision shapes.
    pub(super) shapes: Vec<Shape>,
    /// Boxes, cylinders and balls that are drawn, which stand for absent collision shapes of wheels.
    pub(super) drawn: Vec<Shape>,
}

/// A joint.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    pub(super) name: String,
    pub(super) kind: String,
    pub(super) parent: usize,
    pub(super) child: usize,
    pub(super) pose: Pose,
    pub(super) axis: Point,
    /// Lower and upper limit, effort and velocity, where given.
    pub(super) limit: [Option<f64>; 4],
}

/// A robot: links, joints, and the link without a parent.
#[derive(Clone, Debug)]
pub(super) struct Robot {
    pub(super) links: Vec<Link>,
    pub(super) joints: Vec<Joint>,
    pub(super) root: usize,
}

/// Reads a robot and checks that its joints make a tree.
pub(super) fn read(
    root: &Element,
    file: &Path,
    data: Option<&Path>,
    notes: &mut Notes,
) -> Result<Robot, ImportError> {
    let mut links = Vec::new();
    let mut index = BTreeMap::new();
    for e in root.named("link") {
        let name = e.need("name")?.to_owned();
        if index.insert(name.clone(), links.len()).is_some() {
            return e.fail(format!("a second link has the name {name:?}"));
        }
        if links.len() >= LINKS {
            return e.fail(format!("more than {LINKS} links"));
        }
        links.push(link(e, name, file, data, notes)?);
    }
    let mut joints: Vec<Joint> = Vec::new();
    for e in root.named("joint") {
        joints.push(joint(e, &index)?);
    }
    unread(root, notes);
    let mut parents: Vec<Option<usize>> = vec![None; links.len()];
    for (k, j) in joints.iter().enumerate() {
        if parents[j.child].replace(k).is_some() {
            let problem = format!("the link {:?} has two parents; a robot is a tree", links[j.child].name);
            return Err(ImportError::new(file.display(), format!("joint {}", j.name), problem));
        }
    }
    let roots: Vec<usize> = (0..links.len()).filter(|k| parents[*k].is_none()).collect();
    let root = match roots[..] {
        [one] => one,
        [] => {
            return Err(ImportError::new(
                file.display(),
                "",
                if links.is_empty() {
                    "no link; a xacro file that only defines macros is not a robot: give the file that calls them"
                } else {
                    "the joints make a loop"
                },
            ));
        }
        // Links that no joint holds, such as a camera's frame, are no part of the robot.
        _ => {
            let count = |k: usize| joints.iter().filter(|j| reaches(&joints, &parents, j.child, k)).count();
            let best = roots.iter().copied().max_by_key(|k| count(*k)).unwrap_or(roots[0]);
            for k in roots.iter().filter(|k| **k != best) {
                notes.dropped(format!(
                    "the link {:?}, which no joint connects with {:?}",
                    links[*k].name, links[best].name
                ));
            }
            best
        }
    };
    for (k, link) in links.iter().enumerate() {
        if !roots.iter().any(|r| reaches(&joints, &parents, k, *r)) {
            return Err(ImportError::new(
                file.display(),
                format!("link {}", link.name),
                "its joints make a loop; a robot is a tree",
            ));
        }
    }
    Ok(Robot { links, joints, root })
}

/// Lists the parts of links and joints that have no counterpart, one note for each kind.
fn unread(root: &Element, notes: &mut Notes) {
    let mut found: BTreeMap<(&str, &str), Vec<&str>> = BTreeMap::new();
    for (of, known) in
        [("link", &["inertial", "collision"][..]), ("joint", &["origin", "parent", "child", "axis", "limit"])]
    {
        for e in root.named(of) {
            for c in e.children.iter().filter(|c| !known.contains(&c.name.as_str())) {
                found.entry((of, &c.name)).or_default().push(e.get("name").unwrap_or(""));
            }
        }
    }
    for ((of, kind), mut names) in found {
        names.dedup();
        notes.dropped(format!("<{kind}> of {of}s: {}", names.join(", ")));
    }
}

/// Whether a link hangs on another one.
fn reaches(joints: &[Joint], parents: &[Option<usize>], mut link: usize, root: usize) -> bool {
    for _ in 0..=parents.len() {
        if link == root {
            return true;
        }
        let Some(j) = parents[link] else { return false };
        link = joints[j].parent;
    }
    false
}

fn link(
    e: &Element,
    name: String,
    file: &Path,
    data: Option<&Path>,
    notes: &mut Notes,
) -> Result<Link, ImportError> {
    let mut mass = Mass::default();
    let mut massive = false;
    if let Some(i) = e.child("inertial") {
        let pose = Pose::read(i)?;
        let Some(m) = i.child("mass") else { return i.fail("<mass> is missing") };
        let value = m.number("value")?;
        if value < 0.0 {
            return m.fail(format!("{value} kg; a mass must not be negative"));
        }
        let mut own: Matrix = [[0.0; 3]; 3];
        if let Some(t) = i.child("inertia") {
            for (key, a, b) in
                [("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2)]
            {
                let x = if t.get(key).is_some() { t.number(key)? } else { 0.0 };
                own[a][b] = x;
                own[b][a] = x;
            }
        }
        let turned = product(&product(&pose.axes, &own), &transposed(&pose.axes));
        mass = Mass::body(value, pose.at, &turned);
        massive = value > 0.0;
    }
    let mut shapes = Vec::new();
    for c in e.named("collision") {
        let Some(geometry) = c.child("geometry") else { return c.fail("<geometry> is missing") };
        shapes.extend(placed(c, shape(geometry, &name, file, data, notes)?)?);
    }
    let mut drawn = Vec::new();
    for v in e.named("visual") {
        if let Some(g) = v.child("geometry")
            && g.children.first().is_some_and(|g| g.name != "mesh")
        {
            drawn.extend(placed(v, shape(g, &name, file, data, notes)?)?);
        }
    }
    Ok(Link { name, mass, massive, shapes, drawn })
}

/// The parts of a collision shape or a drawing in the frame of its link.
fn placed(e: &Element, parts: Vec<Vec<Point>>) -> Result<Vec<Shape>, ImportError> {
    let pose = Pose::read(e)?;
    let ball = e.child("geometry").is_some_and(|g| g.child("sphere").is_some());
    let shape = |points: Vec<Point>| Shape { points: points.iter().map(|p| pose.point(*p)).collect(), ball };
    Ok(parts.into_iter().map(shape).collect())
}

fn shape(
    geometry: &Element,
    link: &str,
    file: &Path,
    data: Option<&Path>,
    notes: &mut Notes,
) -> Result<Vec<Vec<Point>>, ImportError> {
    let Some(g) = geometry.children.first() else { return geometry.fail("is empty") };
    Ok(match g.name.as_str() {
        "box" => vec![hull::block(g.triple("size")?)],
        "cylinder" => vec![hull::barrel([0.0, 0.0, 1.0], g.number("radius")?, g.number("length")?)],
        "sphere" => vec![hull::ball(g.number("radius")?)],
        "mesh" => {
            let name = g.need("filename")?;
            let scale = if g.get("scale").is_some() { g.triple("scale")? } else { [1.0; 3] };
            let path = match name.strip_prefix("package://").and_then(|n| n.split_once('/')) {
                Some((pack, rest)) => package(pack, Some(file), data).map(|p| p.join(rest)),
                None => {
                    Some(file.parent().unwrap_or(Path::new(".")).join(name.trim_start_matches("file://")))
                }
            };
            let Some(path) = path.filter(|p| p.is_file()) else {
                notes.dropped(format!(
                    "link {link}: the mesh {name:?}, which is not there; its shape is left out"
                ));
                return Ok(Vec::new());
            };
            let suffix =
                path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
            if !matches!(suffix.as_str(), "stl" | "obj") {
                notes.dropped(format!(
                    "link {link}: the mesh {name:?}; convert it to .stl or .obj for its shape to count"
                ));
                return Ok(Vec::new());
            }
            let parts = hull::mesh(&path)?;
            notes.approximated(format!("link {link}: the mesh {name:?} is replaced by its convex hull"));
            parts
                .into_iter()
                .map(|p| p.iter().map(|q| [q[0] * scale[0], q[1] * scale[1], q[2] * scale[2]]).collect())
                .collect()
        }
        other => {
            notes.dropped(format!("link {link}: a shape of type {other:?}"));
            Vec::new()
        }
    })
}

fn joint(e: &Element, links: &BTreeMap<String, usize>) -> Result<Joint, ImportError> {
    let name = e.need("name")?.to_owned();
    let end = |part: &str| -> Result<usize, ImportError> {
        let Some(p) = e.child(part) else { return e.fail(format!("<{part}> is missing")) };
        let link = p.need("link")?;
        links.get(link).copied().ok_or_else(|| p.error(format!("no link has the name {link:?}")))
    };
    let axis = match e.child("axis") {
        Some(a) => a.triple("xyz")?,
        None => [1.0, 0.0, 0.0],
    };
    let number = |key: &str| match e.child("limit") {
        Some(l) if l.get(key).is_some() => l.number(key).map(Some),
        _ => Ok(None),
    };
    Ok(Joint {
        kind: e.need("type")?.to_owned(),
        parent: end("parent")?,
        child: end("child")?,
        pose: Pose::read(e)?,
        axis,
        limit: [number("lower")?, number("upper")?, number("effort")?, number("velocity")?],
        name,
    })
}
