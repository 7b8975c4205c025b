//! Simulated time waits for answers, or for the wall clock.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use ros2_client::{MessageTypeName, Name, ServiceMapping, ServiceTypeName};
use serde::{Deserialize, Serialize};
use vb_ros::{Options, Pace};
use vb_rosmsg::convert::time_nanoseconds;
use vb_rosmsg::messages::ackermann_msgs::{AckermannDrive, AckermannDriveStamped};
use vb_rosmsg::messages::geometry_msgs::{Twist, TwistStamped};
use vb_rosmsg::messages::nav_msgs::{Odometry, Path};
use vb_rosmsg::messages::std_msgs::Int8;
use vb_sdk::Gear;

use crate::peer::{
    Peer, alone, domain, first_command, observation, options, plugin, reliable, stamped, start, twist,
};

#[derive(Clone, Serialize, Deserialize)]
struct Request {
    nothing: u8,
}

#[derive(Clone, Serialize, Deserialize)]
struct Response {
    success: bool,
    message: String,
}

impl ros2_client::Message for Request {}
impl ros2_client::Message for Response {}

#[test]
fn commands_with_and_without_a_stamp_answer_a_tick() {
    let _alone = alone();
    let wanted = first_command(2.0, 0.2);
    {
        let _peer = Peer::answering(domain(), 2.0, 0.2);
        let plugin = plugin(options());
        assert_eq!(start(&plugin).unwrap().step(&observation(0)).unwrap(), wanted);
    }
    {
        let _peer = Peer::start(domain(), |hands| {
            let commands = hands.publisher::<Twist>("/cmd_vel");
            while hands.tick().is_some() {
                commands.publish(twist(2.0, 0.2)).unwrap();
            }
        });
        let plugin = plugin(options());
        assert_eq!(start(&plugin).unwrap().step(&observation(0)).unwrap(), wanted);
    }
    let _peer = Peer::start(domain(), |hands| {
        let commands = hands.publisher::<AckermannDriveStamped>("/ackermann_cmd");
        while let Some(time) = hands.tick() {
            let drive = AckermannDrive { steering_angle: 0.25, speed: 2.0, ..AckermannDrive::default() };
            let header = vb_rosmsg::convert::header(time, "base_link");
            commands.publish(AckermannDriveStamped { header, drive }).unwrap();
        }
    });
    let plugin = plugin(options());
    let command = start(&plugin).unwrap().step(&observation(0)).unwrap();
    assert_eq!((command.steering, command.throttle), (0.5, wanted.throttle));
}

#[test]
fn a_slow_node_gets_the_same_commands_as_a_fast_one() {
    let _alone = alone();
    let drive = |pause: Duration| {
        let _peer = Peer::start(domain(), move |hands| {
            let commands = hands.publisher::<TwistStamped>("/cmd_vel");
            let mut k = 0.0;
            while let Some(time) = hands.tick() {
                std::thread::sleep(pause);
                commands.publish(stamped(time, 1.0 + k, 0.01 * k)).unwrap();
                k += 0.125;
            }
        });
        let plugin = plugin(options());
        let mut session = start(&plugin).unwrap();
        (0..10).map(|step| session.step(&observation(step)).unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(drive(Duration::ZERO), drive(Duration::from_millis(120)));
}

#[test]
fn plan_odometry_and_clock_have_the_time_of_the_task() {
    let _alone = alone();
    let seen: Arc<Mutex<Vec<(i64, f64, usize)>>> = Arc::default();
    let notes = Arc::clone(&seen);
    let _peer = Peer::start(domain(), move |hands| {
        let latched = reliable().durability(ros2_client::qos::Durability::TransientLocal);
        let node = hands.node();
        let topic = |name: &str, package: &str, kind: &str, qos| {
            node.create_topic(&Name::parse(name).unwrap(), MessageTypeName::new(package, kind), qos).unwrap()
        };
        let (odom, plan) = (
            topic("/odom", "nav_msgs", "Odometry", &reliable()),
            topic("/plan", "nav_msgs", "Path", &latched),
        );
        let odom = node.create_subscription::<Odometry>(&odom, None).unwrap();
        let plan = node.create_subscription::<Path>(&plan, None).unwrap();
        let commands = hands.publisher::<TwistStamped>("/cmd_vel");
        let mut poses = 0;
        while let Some(time) = hands.tick() {
            // The clock comes last, but on another topic.
            let mut odometry = None;
            while hands.goes_on()
                && odometry.as_ref().is_none_or(|o: &Odometry| time_nanoseconds(&o.header.stamp) != time)
            {
                if let Ok(Some((path, _))) = plan.take() {
                    poses = path.poses.len();
                }
                odometry = odom.take().unwrap().map(|(o, _)| o).or(odometry);
            }
            let Some(odometry) = odometry else { return };
            notes.lock().unwrap().push((time, odometry.twist.twist.linear.x, poses));
            commands.publish(stamped(time, 1.0, 0.0)).unwrap();
        }
    });
    let plugin = plugin(Options { places: [("w001/t00".to_owned(), 2)].into(), ..options() });
    let mut session = start(&plugin).unwrap();
    for step in 0..3 {
        session.step(&observation(step)).unwrap();
    }
    let start = 30_000_000_000_000;
    let wanted: Vec<_> = (0..3).map(|k| (start + k * 100_000_000, 1.0, 11)).collect();
    assert_eq!(*seen.lock().unwrap(), wanted);
}

#[test]
fn the_service_lets_a_tick_pass_with_the_command_that_holds() {
    let _alone = alone();
    let _peer = Peer::start(domain(), |hands| {
        let commands = hands.publisher::<TwistStamped>("/cmd_vel");
        let client = hands
            .node()
            .create_client::<Request, Response>(
                ServiceMapping::Enhanced,
                &Name::new("/vertibench", "step").unwrap(),
                &ServiceTypeName::new("std_srvs", "Trigger"),
                reliable(),
                reliable(),
            )
            .unwrap();
        // One command, then calls alone, each after the reply to the one before.
        let Some(time) = hands.tick() else { return };
        commands.publish(stamped(time, 2.0, 0.2)).unwrap();
        for _ in 0..3 {
            client.send_request(Request { nothing: 0 }).unwrap();
            while hands.goes_on() {
                if let Some((_, response)) = client.receive_response().unwrap() {
                    assert!(response.success, "{}", response.message);
                    break;
                }
            }
        }
        hands.wait_for_the_end();
    });
    let plugin = plugin(options());
    let mut session = start(&plugin).unwrap();
    let first = session.step(&observation(0)).unwrap();
    assert_eq!(first, first_command(2.0, 0.2));
    for step in 1..4 {
        assert_eq!(session.step(&observation(step)).unwrap().steering, first.steering);
    }
}

#[test]
fn a_gear_holds_until_the_next_one() {
    let _alone = alone();
    let _peer = Peer::start(domain(), |hands| {
        let gears = hands.publisher::<Int8>("/gear");
        let commands = hands.publisher::<TwistStamped>("/cmd_vel");
        while let Some(time) = hands.tick() {
            if time % 1_000_000_000_000 == 100_000_000 {
                gears.publish(Int8 { data: -1 }).unwrap();
                std::thread::sleep(Duration::from_millis(50));
            }
            commands.publish(stamped(time, 0.0, 0.0)).unwrap();
        }
    });
    let plugin = plugin(options());
    let mut session = start(&plugin).unwrap();
    let gears: Vec<Gear> = (0..3).map(|step| session.step(&observation(step)).unwrap().gear).collect();
    assert_eq!(gears, [Gear::Forward, Gear::Reverse, Gear::Reverse]);
}

#[test]
fn in_real_time_a_node_that_falls_silent_makes_the_vehicle_stop() {
    let _alone = alone();
    let ticks = Arc::new(AtomicU64::new(0));
    let counted = Arc::clone(&ticks);
    let _peer = Peer::start(domain(), move |hands| {
        let commands = hands.publisher::<TwistStamped>("/cmd_vel");
        while let Some(time) = hands.tick() {
            if counted.fetch_add(1, Ordering::Relaxed) < 5 {
                commands.publish(stamped(time, 2.0, 0.0)).unwrap();
            }
        }
    });
    let plugin = plugin(Options { pace: Pace::RealTime { deadline: 0.09 }, ..options() });
    assert_eq!(plugin.departures(), ["real time: the deadline of commands was 0.09 s of wall-clock time"]);
    let mut session = start(&plugin).unwrap();
    #[expect(clippy::disallowed_methods, reason = "the test is about the wall clock")]
    let began = std::time::Instant::now();
    let commands: Vec<_> = (0..14).map(|step| session.step(&observation(step)).unwrap()).collect();
    let took = began.elapsed();
    assert!(took >= Duration::from_millis(1300), "14 ticks of 0.1 s took {took:?}");
    // The command holds for half a second, then the vehicle brakes.
    assert!(commands[2].throttle > 0.0 && commands[5].throttle > 0.0, "{commands:?}");
    assert_eq!((commands[13].throttle, commands[13].brake), (0.0, 1.0));
}
