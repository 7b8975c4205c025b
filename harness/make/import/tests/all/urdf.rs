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
        ("<mass value=\"6\"/>", "<mass value=\"six\"/>", "is not a number"),
        ("<mass value=\"6\"/>", "<mass value=\"-6\"/>", "must not be negative"),
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
        ("<child link=\"mast\"/>", "<child link=\"mist\"/>", "no link has the name \"mist\""),
        ("<link name=\"base\">", &format!("{huge}<link name=\"base\">"), "more than 2000 links"),
        ("</robot>", "", "invalid XML"),
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

#[test]
fn a_robot_that_drives_along_y_is_turned() {
    // The car of above about the upright axis: its front lies at -y, its left at +x.
    let turned = CAR
        .replace("<link name=\"base\">", "<link name=\"world\"/><joint name=\"turn\" type=\"fixed\"><parent link=\"world\"/><child link=\"base\"/><origin rpy=\"0 0 ${-pi/2}\"/></joint><link name=\"base\">");
    let (a, b) = (convert(CAR).unwrap(), convert(&turned).unwrap_or_else(|e| panic!("{e}")));
    assert!(b.notes.of(Kind::Chosen).any(|n| n.text.contains("drives along -y")));
    for (x, y) in a.spec.axles.iter().zip(&b.spec.axles) {
        assert!((x.position[0] - y.position[0]).abs() < 1e-7, "{:?} {:?}", x.position, y.position);
        assert_eq!(x.steering.is_some(), y.steering.is_some());
        assert!((x.suspension.linkage.spindle()[1] - y.suspension.linkage.spindle()[1]).abs() < 1e-7);
    }
    for (x, y) in a.spec.chassis.inertia.iter().zip(&b.spec.chassis.inertia) {
        assert!((x - y).abs() < 1e-7, "{x} {y}");
    }
}

#[test]
fn the_middle_of_a_wheel_is_that_of_its_shape() {
    // The rear wheels stand 0.3 · 0.11 m outside of their joints.
    let beside = CAR.replace(
        "<collision><origin rpy=\"${pi/2} 0 0\"/>",
        "<collision><origin xyz=\"0 ${y * 0.3} 0\" rpy=\"${pi/2} 0 0\"/>",
    );
    let s = convert(&beside).unwrap_or_else(|e| panic!("{e}")).spec;
    assert!((s.axles[1].suspension.linkage.spindle()[1] - 0.143).abs() < 1e-6, "{:?}", s.axles[1]);
    assert!((s.tyre.width() - 0.04).abs() < 1e-9, "{}", s.tyre.width());
}

#[test]
fn shapes_that_are_no_cylinders_stand_for_wheels_with_a_note() {
    let cylinder = "<cylinder radius=\"${r}\" length=\"0.04\"/>";
    let i = convert(&CAR.replace(cylinder, "<sphere radius=\"${r}\"/>")).unwrap();
    assert!((i.spec.tyre.width() - 0.036).abs() < 1e-4, "{}", i.spec.tyre.width());
    assert!(i.notes.of(Kind::Assumed).any(|n| n.text.contains("its shape is a ball")));
    // Without collision shapes, a drawn cylinder is the wheel.
    let drawn = CAR
        .replace("<collision><origin rpy=\"${pi/2} 0 0\"/>", "<visual><origin rpy=\"${pi/2} 0 0\"/>")
        .replace("length=\"0.04\"/></geometry></collision>", "length=\"0.04\"/></geometry></visual>")
        .replace("<visual><geometry><sphere radius=\"1\"/></geometry></visual>", "");
    let i = convert(&drawn).unwrap();
    assert!((i.spec.tyre.radius() - 0.06).abs() < 1e-9);
    assert!(i.notes.of(Kind::Approximated).any(|n| n.text.contains("the wheel's drawing is its shape")));
}

#[test]
fn a_car_drives_the_axles_that_have_motors() {
    let motors = |text: &str| convert(&CAR.replace("</robot>", &format!("{text}</robot>"))).unwrap();
    let driven = |i: &Imported| i.spec.axles.iter().map(|a| a.driven).collect::<Vec<_>>();
    assert_eq!(driven(&motors("")), [true, true]);
    let first = motors(
        "<transmission name=\"t\"><joint name=\"rl_joint\"/><joint name=\"fl_steer\"/></transmission>",
    );
    assert_eq!((driven(&first), first.spec.powertrain.driveline.axles.len()), (vec![false, true], 1));
    // Two joints of 0.5 N m.
    assert!((first.spec.powertrain.engine.torque(0.0, 1.0) - 1.0).abs() < 1e-9);
    let second = "<ros2_control><joint name=\"fl_joint\"><command_interface name=\"velocity\"/></joint><joint name=\"rl_joint\"><state_interface name=\"position\"/></joint></ros2_control>";
    assert_eq!(driven(&motors(second)), [true, false]);
}

#[test]
fn limits_that_limit_nothing_are_none() {
    let i =
        convert(&CAR.replace("effort=\"0.5\" velocity=\"50\"", "effort=\"1e6\" velocity=\"1e6\"")).unwrap();
    assert!(i.spec.max_speed < 2.1, "{}", i.spec.max_speed);
    // 0.6 of the weight of 7.7 kg at the radius.
    let torque = 0.6 * 7.7 * vb_vehicle::GRAVITY * 0.06;
    assert!((i.spec.powertrain.engine.torque(0.0, 1.0) - torque).abs() < 1e-6);
}

#[test]
fn casters_and_wheels_that_roll_sideways_are_refused() {
    let caster = CAR
        .replace("<limit lower=\"-0.4\" upper=\"0.4\" effort=\"1\" velocity=\"3\"/>", "")
        .replace("type=\"revolute\"", "type=\"continuous\"");
    // Above the wheel's centre it is a steered wheel, behind it a caster.
    let i = convert(&caster).unwrap();
    assert!(i.notes.of(Kind::Assumed).any(|n| n.text.contains("steers by up to 0.5 rad")));
    let behind = caster.replace("parent=\"${name}_hinge\" x=\"0\"", "parent=\"${name}_hinge\" x=\"-0.03\"");
    let e = convert(&behind).unwrap_err().to_string();
    assert!(e.contains("joint fl_steer: a passive caster") && !e.contains('\n'), "{e}");
    let e = convert(&CAR.replace("name=\"small car\"", "name=\"mecanum car\"")).unwrap_err().to_string();
    assert!(e.contains("wheels that roll sideways have no counterpart"), "{e}");
    let plugin = CAR
        .replace("</robot>", "<gazebo><plugin filename=\"libgazebo_ros_planar_move.so\"/></gazebo></robot>");
    assert!(convert(&plugin).unwrap().notes.of(Kind::NoCounterpart).any(|n| n.text.contains("planar_move")));
}

#[test]
fn parts_of_joints_are_listed() {
    let text = CAR.replace(
        "<axis xyz=\"0 1 0\"/>",
        "<axis xyz=\"0 1 0\"/><dynamics damping=\"0.1\"/><mimic joint=\"x\"/>",
    );
    let i = convert(&text).unwrap();
    for what in ["<dynamics> of joints: ", "<mimic> of joints: ", "<visual> of links: "] {
        assert!(i.notes.of(Kind::NoCounterpart).any(|n| n.text.starts_with(what)), "{what}");
    }
}
