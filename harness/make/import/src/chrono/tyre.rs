//! Tyres.

use super::json::{Doc, Node};
use super::set::{Set, template};
use super::tir;
use crate::{ImportError, Notes};
use vb_vehicle::tyre::{BrushTyre, FialaTyre, HardContact, RigidTyre, TmeasyTyre, TyreSpec};

/// A tyre and its inertia about the wheel's axis.
#[derive(Clone, Debug)]
pub(crate) struct Tyre {
    pub(crate) spec: TyreSpec,
    pub(crate) spin: f64,
}

/// The templates that have a counterpart, the preferred one first.
pub(crate) const TEMPLATES: &[&str] = &[
    "TMeasyTire",
    "FialaTire",
    "TMsimpleTire",
    "MFTire",
    "Pac02Tire",
    "Pac89Tire",
    "PacejkaTire",
    "RigidTire",
];

/// Damping ratio of carcasses, as of the shipped vehicles.
const CARCASS: f64 = 0.25;

/// Reads a tyre's file. `load` is the weight on a wheel, N.
pub(crate) fn read(set: &Set, doc: &Doc, load: f64, notes: &mut Notes) -> Result<Tyre, ImportError> {
    let root = doc.root();
    match template(doc)?.as_str() {
        "TMeasyTire" => tmeasy(&root, load, notes),
        "TMsimpleTire" => {
            notes.approximated(format!(
                "{}: TMsimple is represented by TMeasy with the same slopes, maxima and sliding forces",
                doc.file
            ));
            tmeasy(&root, load, notes)
        }
        "FialaTire" => fiala(&root, load, notes),
        "MFTire" | "Pac02Tire" | "PacejkaTire" => magic(set, &root, load, notes),
        "Pac89Tire" => pac89(&root, load, notes),
        "RigidTire" => rigid(&root, load, notes),
        other => root.fail(format!(
            "no counterpart of the tyre {other:?}; choose a file of {} with --tyre",
            TEMPLATES.join(", ")
        )),
    }
}

/// The mass of a wheel's tyre, which the load on the wheels depends on.
pub(crate) fn mass(doc: &Doc) -> Result<f64, ImportError> {
    let root = doc.root();
    match root.get("Design") {
        Some(d) => d.num("Mass [kg]"),
        None => root.num_or("Mass", 0.0),
    }
}

/// Two equal tyres of a twin wheel as one; see [`TyreSpec::make_twin`].
pub(crate) fn twin(mut t: Tyre, separation: f64) -> Tyre {
    t.spec.make_twin(separation);
    Tyre { spin: 2.0 * t.spin, ..t }
}

/// The inertia about the wheel's axis, which files of Chrono 3 and before give only for the wheel.
fn spin(root: &Node, notes: &mut Notes) -> Result<f64, ImportError> {
    if let Some(n) = root.get("Inertia") {
        return Ok(n.point()?[1]);
    }
    notes.assumed(format!("{}: mass and inertia of the tyre are in those of the wheel", root.doc().file));
    Ok(0.0)
}

fn square(k: f64, load: f64) -> f64 {
    2.0 * CARCASS * (k * load / vb_vehicle::GRAVITY).sqrt()
}

/// Carcass stiffness for relaxation lengths of half a radius and of one, and its damping.
fn carcass(slopes: [f64; 2], radius: f64, load: f64) -> ([f64; 2], [f64; 2]) {
    let stiffness = [slopes[0] / (0.5 * radius), slopes[1] / radius];
    (stiffness, stiffness.map(|k| square(k, load)))
}

const CARCASS_NOTE: &str = "carcass: relaxation lengths of half a radius along and one radius across (Pacejka 2012, ch. 7), a quarter of critical damping";

fn friction(root: &Node) -> Result<f64, ImportError> {
    root.num_or("Coefficient of Friction", 0.8)
}

fn rolling(root: &Node, notes: &mut Notes) -> Result<f64, ImportError> {
    let Some(n) = root.any(&["Rolling Resistance Coefficient", "Rolling Resistance Coefficients"]) else {
        notes.assumed(format!("{}: rolling resistance of 0.015", root.doc().file));
        return Ok(0.015);
    };
    if let Ok(x) = n.number() {
        return Ok(x);
    }
    let both = n.numbers()?;
    if both.len() > 1 && both[0] != both[1] {
        notes.approximated(format!(
            "{}: the value at the nominal load, {}, is used at all loads",
            n.at(),
            both[0]
        ));
    }
    both.first().copied().ok_or_else(|| n.error("a number is expected"))
}

fn tmeasy(root: &Node, load: f64, notes: &mut Notes) -> Result<Tyre, ImportError> {
    let design = root.need("Design")?;
    let (radius, width) = (design.num("Unloaded Radius [m]")?, design.num("Width [m]")?);
    let (rim_radius, mass) = (design.num("Rim Radius [m]")?, design.num("Mass [kg]")?);
    let spin = design.pt("Inertia [kg.m2]")?[1];
    let mut t = match root.get("Parameters") {
        Some(p) if p.has("Tire Load") => parameters(&p, radius, width, rim_radius)?,
        Some(p) => simple(&p, radius, width, rim_radius, notes)?,
        None => guessed(root, radius, width, rim_radius, mass, notes)?,
    };
    t.mu_0 = friction(root)?;
    t.rolling_resistance = rolling(root, notes)?;
    let given = t.carcass_stiffness[0] > 0.0 && t.carcass_stiffness[1] > 0.0;
    if !given {
        (t.carcass_stiffness, t.carcass_damping) = carcass([t.dfx0[0], t.dfy0[0]], radius, load);
        notes.assumed(format!("{}: {CARCASS_NOTE}", root.doc().file));
    }
    Ok(Tyre { spec: TyreSpec::Tmeasy(t), spin })
}

fn blank(radius: f64, width: f64, rim_radius: f64, pn: f64) -> TmeasyTyre {
    let zero = [0.0; 2];
    TmeasyTyre {
        radius,
        width,
        rim_radius,
        rolling_resistance: 0.0,
        mu_0: 0.8,
        pn,
        pn_max: 3.5 * pn,
        vertical_stiffness: 0.0,
        vertical_stiffness_growth: 0.0,
        vertical_damping: 0.0,
        dfx0: zero,
        fxm: zero,
        sxm: zero,
        fxs: zero,
        sxs: zero,
        dfy0: zero,
        fym: zero,
        sym: zero,
        fys: zero,
        sys: zero,
        nl0: zero,
        sq0: zero,
        sqe: zero,
        carcass_stiffness: zero,
        carcass_damping: zero,
    }
}

/// The full set of parameters.
fn parameters(p: &Node, radius: f64, width: f64, rim_radius: f64) -> Result<TmeasyTyre, ImportError> {
    let tyre = p.need("Tire Load")?;
    let mut t = blank(radius, width, rim_radius, tyre.num("Nominal Vertical Force [N]")?);
    t.pn_max = tyre.num_or("Maximum Vertical Force [N]", t.pn_max)?;
    let stiffness = p.need("Tire Stiffness")?;
    t.carcass_stiffness = [stiffness.num("Longitudinal [N/m]")?, stiffness.num("Lateral [N/m]")?];
    let vertical = stiffness.need("Vertical [N/m]")?;
    (t.vertical_stiffness, t.vertical_stiffness_growth) = match vertical.number() {
        Ok(k) => (k, 0.0),
        Err(_) => {
            match vertical.numbers()?[..] {
                // Stiffnesses at the nominal load and at twice that; the force is a1 z + a2 z².
                [k1, k2] => {
                    let a1 = 2.0 * k1 * k1 - k2 * k2;
                    if a1 <= 0.0 {
                        return vertical.fail(format!("{k2} is more than 1.4 times {k1}; no tyre that hardens so has a stiffness at no load"));
                    }
                    (a1.sqrt(), (k2 * k2 - k1 * k1) / (4.0 * t.pn))
                }
                _ => return vertical.fail("one or two numbers are expected"),
            }
        }
    };
    let damping = p.need("Tire Damping")?;
    t.carcass_damping = [damping.num("Longitudinal [Ns/m]")?, damping.num("Lateral [Ns/m]")?];
    t.vertical_damping = damping.num("Vertical [Ns/m]")?;
    let (x, y, a) = (p.need("Longitudinal")?, p.need("Lateral")?, p.need("Aligning")?);
    t.dfx0 = pair(&x, "Initial Slopes dFx/dsx [N]")?;
    t.fxm = pair(&x, "Maximum Fx Load [N]")?;
    t.fxs = pair(&x, "Sliding Fx Load [N]")?;
    t.sxm = pair(&x, "Slip sx at Maximum Fx")?;
    t.sxs = pair(&x, "Slip sx where sliding begins")?;
    t.dfy0 = pair(&y, "Initial Slopes dFy/dsy [N]")?;
    t.fym = pair(&y, "Maximum Fy Load [N]")?;
    t.fys = pair(&y, "Sliding Fy Load [N]")?;
    t.sym = pair(&y, "Slip sy at Maximum Fy")?;
    t.sys = pair(&y, "Slip sy where sliding begins")?;
    t.nl0 = pair(&a, "Normalized Trail at Zero Slip sy")?;
    t.sq0 = pair(&a, "Slip sy where Trail Changes Sign")?;
    t.sqe = pair(&a, "Slip sy where Trail Tends to Zero")?;
    Ok(t)
}

/// Values at the nominal load and at twice that.
fn pair(node: &Node, key: &str) -> Result<[f64; 2], ImportError> {
    let n = node.need(key)?;
    <[f64; 2]>::try_from(n.numbers()?)
        .or_else(|_| n.fail("two numbers are expected, at the nominal load and at twice that"))
}

/// The parameters of TMsimple (Hirschberg): the force over the slip s is K sin(B (1 - exp(-s / A))) with the maximum K,
/// B = π - asin(sliding force / K) and A = K B / initial slope.
fn simple(
    p: &Node,
    radius: f64,
    width: f64,
    rim_radius: f64,
    notes: &mut Notes,
) -> Result<TmeasyTyre, ImportError> {
    let vertical = p.need("Vertical")?;
    let mut t = blank(radius, width, rim_radius, vertical.num("Nominal Vertical Force [N]")?);
    t.vertical_stiffness = match vertical.get("Tire Spring Curve Data") {
        Some(n) => {
            vertical.get("Vertical Tire Stiffness [N/m]").inspect(Node::used);
            secant(&n.table()?, t.pn).ok_or_else(|| n.error("no rising table of deflection and force"))?
        }
        None => vertical.num("Vertical Tire Stiffness [N/m]")?,
    };
    t.vertical_damping = vertical.num("Vertical Tire Damping [Ns/m]")?;
    let curve = |axis: &str, letter: &str| -> Result<[[f64; 2]; 5], ImportError> {
        let n = p.need(axis)?;
        let slope = pair(&n, &format!("Initial Slopes dF{letter}/ds{letter} [N]"))?;
        let most = pair(&n, &format!("Maximum F{letter} Load [N]"))?;
        let sliding = pair(&n, &format!("Sliding F{letter} Load [N]"))?;
        let (mut top, mut end) = ([0.0; 2], [0.0; 2]);
        for k in 0..2 {
            if !(slope[k] > 0.0 && most[k] > 0.0 && sliding[k] > 0.0 && sliding[k] <= most[k]) {
                return n.fail(format!(
                    "slope {}, maximum {} and sliding force {}; all must be positive, and no force may exceed the maximum",
                    slope[k], most[k], sliding[k]
                ));
            }
            let ratio = sliding[k] / most[k];
            let b = std::f64::consts::PI - vb_math::asin(ratio);
            let a = most[k] * b / slope[k];
            top[k] = -a * vb_math::ln(1.0 - (0.5 * std::f64::consts::PI / b).min(0.99));
            // 95 % of the way to sliding.
            end[k] = f64::max(3.0 * a, 1.5 * top[k]);
        }
        Ok([slope, most, top, sliding, end])
    };
    [t.dfx0, t.fxm, t.sxm, t.fxs, t.sxs] = curve("Longitudinal", "x")?;
    [t.dfy0, t.fym, t.sym, t.fys, t.sys] = curve("Lateral", "y")?;
    trail(&mut t);
    notes.assumed(format!("{}: the pneumatic trail is that of a truck tyre", p.at()));
    Ok(t)
}

/// The pneumatic trail of tyres of which only forces are known.
fn trail(t: &mut TmeasyTyre) {
    t.nl0 = [0.178, 0.19];
    t.sq0 = t.sym.map(|s| 1.1 * s);
    t.sqe = t.sys;
}

/// Load of a load index, kg: the geometric series of which the table of ETRTO has the rounded terms (within 1 %).
fn index_load(index: f64) -> f64 {
    45.0 * vb_math::pow(10.0, index / 80.0)
}

/// Slope, maximum, its slip, sliding force and its slip, along and across, and the slip at which the trail changes its sign.
type Curves = ([[f64; 2]; 5], [[f64; 2]; 5], [f64; 2]);
const TRUCK: Curves = (
    [[17.7764, 14.5301], [0.89965, 0.77751], [0.10811, 0.12389], [0.46183, 0.42349], [0.66667, 0.66667]],
    [[7.4013, 6.8505], [0.75876, 0.72628], [0.33167, 0.33216], [0.68276, 0.65319], [1.0296, 1.0296]],
    [0.36484, 0.36538],
);
const CAR: Curves = (
    [[18.6758, 20.1757], [1.1205, 1.072], [0.17, 0.15], [0.8766, 0.8245], [0.9, 0.95]],
    [[14.9858, 10.0505], [1.0084, 0.90003], [0.18197, 0.24472], [0.83941, 0.76782], [0.82534, 0.91309]],
    [0.19107, 0.25695],
);

/// Chrono's guess from load and size (ChTMeasyTire::GuessTruck80Par and GuessPassCar70Par of version 9.0.1).
fn guessed(
    root: &Node,
    radius: f64,
    width: f64,
    rim_radius: f64,
    mass: f64,
    notes: &mut Notes,
) -> Result<TmeasyTyre, ImportError> {
    let truck = match root.get("Vehicle Type") {
        Some(n) => !n.text()?.to_ascii_lowercase().contains("passenger"),
        None => true,
    };
    let full = match (root.get("Load Index"), root.get("Maximum Bearing Capacity [N]")) {
        (Some(n), other) => {
            other.as_ref().inspect(|n| n.used());
            index_load(n.number()?) * vb_vehicle::GRAVITY
        }
        (None, Some(n)) => n.number()?,
        (None, None) => {
            return root.fail(
                "neither Parameters nor Load Index nor Maximum Bearing Capacity [N]; give one of them",
            );
        }
    };
    let pressure = |key: &str| root.num_or(key, 0.0);
    let (of_load, in_use) =
        (pressure("Inflation Pressure Design [Pa]")?, pressure("Inflation Pressure Use [Pa]")?);
    let fraction = if of_load > 0.0 && in_use > 0.0 { vb_math::pow(in_use / of_load, 0.8) } else { 1.0 };
    let pn = 0.5 * full * fraction;
    let mut t = blank(radius, width, rim_radius, pn);
    t.vertical_stiffness = 2.0 * pn / (0.16 * (radius - rim_radius));
    t.vertical_damping = (t.vertical_stiffness * mass).sqrt();
    // Forces at the nominal load and at twice that, each over its load: slope, maximum, sliding force; and the slips of both.
    let (x, y, zero) = if truck { TRUCK } else { CAR };
    let at = |k: [f64; 2]| [k[0] * pn, 2.0 * k[1] * pn];
    let forces =
        |[slope, most, top, sliding, end]: [[f64; 2]; 5]| [at(slope), at(most), top, at(sliding), end];
    [t.dfx0, t.fxm, t.sxm, t.fxs, t.sxs] = forces(x);
    [t.dfy0, t.fym, t.sym, t.fys, t.sys] = forces(y);
    trail(&mut t);
    t.sq0 = zero;
    let kind = if truck { "truck" } else { "passenger car" };
    notes.approximated(format!(
        "{}: parameters follow from the load of {full:.0} N and the size, as in Chrono's generator for {kind} tyres",
        root.doc().file
    ));
    Ok(t)
}

fn fiala(root: &Node, load: f64, notes: &mut Notes) -> Result<Tyre, ImportError> {
    let p = root.need("Fiala Parameters")?;
    let (radius, width) = (p.num("Unloaded Radius")?, p.num("Width")?);
    let stiffness = p.num_or("Vertical Stiffness", 0.0)?;
    let vertical_map = match p.get("Vertical Curve Data") {
        Some(n) => n.table()?,
        None if stiffness > 0.0 => vec![[0.0, 0.0], [0.1 * radius, 0.1 * radius * stiffness]],
        None => return p.fail("neither Vertical Stiffness nor Vertical Curve Data"),
    };
    let (c_slip, c_alpha) = (p.num("CSLIP")?, p.num("CALPHA")?);
    let (mut stiff, mut damp) = carcass([c_slip, c_alpha], radius, load);
    for (k, key, slope) in [(0, "X Relaxation Length", c_slip), (1, "Y Relaxation Length", c_alpha)] {
        let sigma = p.num_or(key, 0.0)?;
        if sigma > 0.0 {
            stiff[k] = slope / sigma;
            damp[k] = square(stiff[k], load);
        } else {
            notes.assumed(format!("{}: {CARCASS_NOTE}", root.doc().file));
        }
    }
    let spec = FialaTyre {
        radius,
        width,
        vertical_map,
        vertical_damping: p.num_or("Vertical Damping", 0.0)?,
        c_slip,
        c_alpha,
        mu_min: p.num("UMIN")?,
        mu_max: p.num("UMAX")?,
        mu_0: friction(root)?,
        rolling_resistance: p.num_or("Rolling Resistance", 0.0)?,
        carcass_stiffness: stiff,
        carcass_damping: damp,
    };
    Ok(Tyre { spec: TyreSpec::Fiala(spec), spin: spin(root, notes)? })
}

fn brush(
    radius: f64,
    width: f64,
    vertical: [f64; 2],
    slip_stiffness: [f64; 2],
    friction: f64,
    rolling: f64,
) -> BrushTyre {
    BrushTyre {
        radius,
        width,
        friction,
        vertical_stiffness: vertical[0],
        vertical_damping: vertical[1],
        slip_stiffness,
        relaxation_length: [0.5 * radius, radius],
        damping_ratio: CARCASS,
        rolling_resistance: rolling,
    }
}

/// A Magic Formula tyre as the brush with its slopes and its friction at the wheel's load.
fn magic(set: &Set, root: &Node, load: f64, notes: &mut Notes) -> Result<Tyre, ImportError> {
    let tir = match root.any(&["TIR Specification File", "Pacejka Parameter File"]) {
        Some(file) => {
            let path = set.place(&file)?;
            tir::Tir::read(&path, &set.short(&path))?
        }
        None => tir::Tir::inline(root)?,
    };
    let m = tir.brush(load)?;
    root.get("Coefficient of Friction").map(|n| n.number()).transpose()?;
    notes.approximated(format!(
        "{}: the Magic Formula is represented by a brush with its slopes and the mean of its peak frictions at {load:.0} N; camber, \
         combined slip and the fall after the peak are left out",
        root.doc().file
    ));
    notes.assumed(format!("{}: {CARCASS_NOTE}", root.doc().file));
    notes.dropped(format!("{}: all coefficients but sizes, vertical stiffness and damping, PDX1-2, PDY1-2, PKX1-3, PKY1-2 and their scale factors", tir.file));
    let spec = brush(m.radius, m.width, m.vertical, m.slopes, m.friction, m.rolling);
    let spin = root.get("Inertia").map_or(Ok(m.spin), |n| n.point().map(|p| p[1]))?;
    Ok(Tyre { spec: TyreSpec::Brush(spec), spin })
}

fn pac89(root: &Node, load: f64, notes: &mut Notes) -> Result<Tyre, ImportError> {
    let d = root.need("Design Parameters")?;
    let (lateral, longitudinal) =
        (root.need("Lateral Coefficients")?, root.need("Longitudinal Coefficients")?);
    let (radius, width) = (d.num("Unloaded Radius")?, d.num("Width")?);
    let fz = 0.001 * load;
    let a = |k: &str| lateral.num(k);
    let b = |k: &str| longitudinal.num(k);
    // Slopes per degree of slip angle and per percent of slip, N (Pacejka 1989).
    let across =
        a("a3")? * vb_math::sin_cos(2.0 * vb_math::atan2(fz, a("a4")?)).0 * 180.0 / std::f64::consts::PI;
    let along =
        (b("b3")? * fz * fz + b("b4")? * fz) * vb_math::pow(std::f64::consts::E, -b("b5")? * fz) * 100.0;
    let peaks = [(b("b1")? * fz + b("b2")?) * fz / load, (a("a1")? * fz + a("a2")?) * fz / load];
    let stiffness = match d.get("Vertical Curve Data") {
        Some(n) => {
            let table = n.table()?;
            d.get("Vertical Stiffness").inspect(Node::used);
            secant(&table, load).ok_or_else(|| n.error("no rising table of deflection and force"))?
        }
        None => d.num("Vertical Stiffness")?,
    };
    notes.approximated(format!(
        "{}: the Magic Formula of 1989 is represented by a brush with its slopes and peak frictions at {load:.0} N",
        root.doc().file
    ));
    notes.assumed(format!("{}: {CARCASS_NOTE}", root.doc().file));
    let spec = brush(
        radius,
        width,
        [stiffness, d.num_or("Vertical Damping", 0.0)?],
        [along.abs() / load, across.abs() / load],
        0.5 * (peaks[0].abs() + peaks[1].abs()),
        d.num_or("Rolling Resistance", 0.015)?,
    );
    friction(root)?;
    Ok(Tyre { spec: TyreSpec::Brush(spec), spin: spin(root, notes)? })
}

/// The load over the deflection under it.
fn secant(table: &[[f64; 2]], load: f64) -> Option<f64> {
    let k = table.windows(2).find(|w| w[1][1] >= load).or_else(|| table.windows(2).last())?;
    let slope = (k[1][1] - k[0][1]) / (k[1][0] - k[0][0]);
    let depth = k[0][0] + (load - k[0][1]) / slope;
    (slope > 0.0 && depth > 0.0).then(|| load / depth)
}

fn rigid(root: &Node, load: f64, notes: &mut Notes) -> Result<Tyre, ImportError> {
    let (radius, width) = (root.num("Radius")?, root.num("Width")?);
    let key = "Coefficient of Friction";
    let mu = root.get("Contact Material").map_or_else(|| root.num(key), |m| m.num(key))?;
    notes.assumed(format!(
        "{}: stiffnesses of the rigid tyre are those of the shipped vehicles' at its load: half a percent of the radius at rest, \
         full friction at a slip of some percent",
        root.doc().file
    ));
    Ok(Tyre { spec: TyreSpec::Rigid(hard(radius, width, mu, load)), spin: spin(root, notes)? })
}

/// A hard wheel under a load.
pub(crate) fn hard(radius: f64, width: f64, friction: f64, load: f64) -> RigidTyre {
    let vertical_stiffness = load / (0.005 * radius);
    let tangential_stiffness = 1.6 * vertical_stiffness;
    // Critical for a tenth of the mass on the wheel, a third of critical for a twentieth.
    let mass = load / vb_vehicle::GRAVITY;
    RigidTyre {
        radius,
        width,
        friction,
        vertical_stiffness,
        vertical_damping: 2.0 * (vertical_stiffness * 0.1 * mass).sqrt(),
        tangential_stiffness,
        tangential_damping: 0.66 * (tangential_stiffness * 0.05 * mass).sqrt(),
        relaxation_length: 0.214 * radius,
        contact: HardContact::Envelope,
        dilation: None,
    }
}
