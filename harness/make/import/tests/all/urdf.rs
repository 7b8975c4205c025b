//! Robots.

use vb_import::{ImportError, Imported, Kind, Options, import};
use vb_vehicle::skid::Skid;
use vb_vehicle::suspension::{Linkage, SteeredBy, SteeringGear};

/// A car of 8 kg with steered front wheels, as xacro.
const CAR: &str = r#"<?xml version="1.0"?>
<robot name="small car" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:property name="r" value="0.06"/>
  <xacro:macro name="wheel" params="name parent x y">
    <link name="${name}">
      <inertial><mass value="0.3"/><inertia ixx="3e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="3e-4"/></inertial>
      <collision><origin rpy="${pi/2} 0 0"/><geometry><cylinder radius="${r}" length="0.04"/></geometry></collision>
      <visual><geometry><sphere radius="1"/></geometry></visual>
    </link>
    <joint name="${name}_joint" type="continuous">
      <parent link="${parent}"/><child link="${name}"/><origin xyz="${x} ${y} 0"/><axis xyz="0 1 0"/>
      <limit effort="0.5" velocity="50"/>
    </joint>
  </xacro:macro>
  <xacro:macro name="steered" params="name y">
    <link name="${name}_hinge"/>
    <joint name="${name}_steer" type="revolute">
      <parent link="base"/><child link="${name}_hinge"/><origin xyz="0.16 ${y} 0"/><axis xyz="0 0 1"/>
      <limit lower="-0.4" upper="0.4" effort="1" velocity="3"/>
    </joint>
    <xacro:wheel name="${name}" parent="${name}_hinge" x="0" y="0"/>
  </xacro:macro>
  <link name="base">
    <inertial><origin xyz="0 0 0.03"/><mass value="6"/><inertia ixx="0.03" ixy="0" ixz="0.001" iyy="0.1" iyz="0" izz="0.11"/></inertial>
    <collision><origin xyz="0 0 0.04"/><geometry><box size="0.4 0.16 0.06"/></geometry></collision>
  </link>
  <link name="mast"><inertial><mass value="0.5"/><inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial></link>
  <joint name="mast_joint" type="fixed"><parent link="base"/><child link="mast"/><origin xyz="0 0 0.2"/></joint>
  <xacro:steered name="fl" y="0.11"/>
  <xacro:steered name="fr" y="-0.11"/>
  <xacro:wheel name="rl" parent="base" x="-0.16" y="0.11"/>
  <xacro:wheel name="rr" parent="base" x="-0.16" y="-0.11"/>
  <gazebo reference="base"><mu1>1</mu1></gazebo>
</robot>
"#;

fn convert(text: &str) -> Result<Imported, ImportError> {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("car.xacro");
    std::fs::write(&file, text).unwrap();
    import(&file, &Options::default())
}

#[test]
fn a_robot_with_steered_wheels_is_a_vehicle() {
    let i = convert(CAR).unwrap_or_else(|e| panic!("{e}"));
    let s = &i.spec;
    assert_eq!(s.name, "small_car");
    // Base and mast, without the wheels; the hinges have no mass.
    assert!((s.chassis.mass - 6.5).abs() < 1e-9);
    assert!((s.chassis.com[2] - (6.0 * 0.03 + 0.5 * 0.2) / 6.5).abs() < 1e-8, "{:?}", s.chassis.com);
    assert_eq!(s.chassis.hull.len(), 1);
    assert!((s.tyre.radius() - 0.06).abs() < 1e-9 && (s.tyre.width() - 0.04).abs() < 1e-9);
    assert!(
        (s.axles[0].position[0] - 0.16).abs() < 1e-9
            && (s.axles[0].suspension.linkage.spindle()[1] - 0.11).abs() < 1e-9
    );
    assert!(matches!(s.axles[0].steering, Some(SteeringGear::RackAndPinion { .. })));
    assert!(matches!(s.axles[1].suspension.linkage, Linkage::Rigid(_)));
    assert!((s.axles[1].unsprung_mass - 0.3).abs() < 1e-9 && (s.axles[1].spin_inertia - 5e-4).abs() < 1e-9);
    // 0.44 m long: worlds at 1/9.
    assert!((s.scale - 1.0 / 9.0).abs() < 1e-12, "{}", s.scale);
    let listed = |what: &str| i.notes.of(Kind::NoCounterpart).any(|n| n.text.contains(what));
    assert!(listed("<gazebo>") && listed("<visual>") && listed("products of inertia"));
}

#[test]
fn a_robot_without_steered_wheels_turns_by_the_speeds_of_its_sides() {
    let i = convert(&CAR.replace("type=\"revolute\"", "type=\"fixed\"")).unwrap();
    assert!(matches!(i.spec.skid, Some(Skid::Speed { relative: 1.0, .. })));
    assert_eq!(i.spec.steering.by, SteeredBy::Differential);
    assert!(i.spec.max_speed > 0.5, "{}", i.spec.max_speed);
    assert!(i.notes.of(Kind::Assumed).any(|n| n.text.contains("no joint steers a wheel")));
}

#[test]
fn robots_that_are_no_vehicles_are_refused_in_one_line() {
    let joint = "type=\"continuous\"";
    let huge: String = (0..2100).map(|k| format!("<link name=\"l{k}\"/>")).collect();
    for (from, to, says) in [
        (joint, "type=\"fixed\"", "no wheels: no continuous joint"),
        ("x=\"-0.16\" y=\"-0.11\"", "x=\"-0.3\" y=\"-0.11\"", "no wheel stands opposite"),
        ("<mass value=\"6\"/>", "<mass value=\"six\"/>", "is no number"),
        ("<mass value=\"6\"/>", "<mass value=\"-6\"/>", "not negative"),
        (
            "<parent link=\"base\"/><child link=\"mast\"/>",
            "<parent link=\"mast\"/><child link=\"mast\"/>",
            "loop",
        ),
        (
            "<parent link=\"base\"/><child link=\"mast\"/>",
            "<parent link=\"base\"/><child link=\"fl\"/>",
            "two parents",
        ),
        ("<child link=\"mast\"/>", "<child link=\"mist\"/>", "no link is called \"mist\""),
        ("<link name=\"base\">", &format!("{huge}<link name=\"base\">"), "more than 2000 links"),
        ("</robot>", "", "no valid XML"),
    ] {
        assert!(CAR.contains(from), "{from}");
        let e = convert(&CAR.replace(from, to)).expect_err(from).to_string();
        assert!(e.contains(says) && !e.contains('\n'), "{from}: {e}");
    }
}

#[test]
fn a_loop_of_includes_and_a_huge_mesh_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("a.xacro");
    let text = "<robot name=\"a\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:include filename=\"b.xacro\"/></robot>";
    std::fs::write(&file, text).unwrap();
    std::fs::write(dir.path().join("b.xacro"), text.replace("b.xacro", "a.xacro")).unwrap();
    let e = import(&file, &Options::default()).unwrap_err().to_string();
    assert!(e.contains("includes itself"), "{e}");

    let mesh = dir.path().join("m.stl");
    std::fs::File::create(&mesh).unwrap().set_len(65 << 20).unwrap();
    std::fs::write(&file, CAR.replace("<box size=\"0.4 0.16 0.06\"/>", "<mesh filename=\"m.stl\"/>"))
        .unwrap();
    let e = import(&file, &Options::default()).unwrap_err().to_string();
    assert!(e.contains("larger than"), "{e}");
    std::fs::remove_file(&mesh).unwrap();
    let i = import(&file, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
    assert!(i.notes.of(Kind::NoCounterpart).any(|n| n.text.contains("m.stl")));
}
