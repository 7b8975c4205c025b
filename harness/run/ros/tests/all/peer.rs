//! Nodes of tests, and what drives them: one node of the harness at a time, in a domain that other test programs hardly use.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use ros2_client::qos::{History, QosProfile, WhenFull};
use ros2_client::{Context, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher, Subscription};
use rustdds::DomainParticipantBuilder;
use serde::Serialize;
use vb_host::{FaultCode, Limits, LogSink, PlannerFault, Plugin, Session};
use vb_ros::Options;
use vb_rosmsg::Message;
use vb_rosmsg::convert::{header, time_nanoseconds};
use vb_rosmsg::messages::geometry_msgs::{Twist, TwistStamped, Vector3};
use vb_rosmsg::messages::rosgraph_msgs::Clock;
use vb_sdk::{Command, Observation, Point2, Pose, Task, Vec3, Vehicle};

/// Held by a test while it uses the network.
pub(crate) fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A domain of this program. There are 233, of which people use the first.
pub(crate) fn domain() -> u16 {
    100 + (std::process::id() % 130) as u16
}

/// Options for tests: nobody waits for long.
pub(crate) fn options() -> Options {
    Options {
        domain: domain(),
        start_timeout: Duration::from_secs(10),
        answer_timeout: Duration::from_secs(10),
        ..Options::default()
    }
}

/// A node of a test.
pub(crate) struct Peer {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// What a peer does with the node that it is.
pub(crate) struct Hands {
    node: Node,
    clock: Subscription<Clock>,
    stop: Arc<AtomicBool>,
    last: i64,
}

pub(crate) fn reliable() -> QosProfile {
    QosProfile::publisher_default()
        .reliability_reliable(WhenFull::Wait(Duration::from_millis(200)))
        .history(History::KeepLast { depth: 2000 })
}

impl Hands {
    /// A publisher of messages under the type name of `M`.
    pub(crate) fn publisher<M: Message>(&mut self, topic: &str) -> Publisher<M> {
        self.publisher_of(topic, M::PACKAGE, M::TYPE, &reliable())
    }

    /// A publisher of messages under any type name.
    pub(crate) fn publisher_of<D: Serialize>(
        &mut self,
        topic: &str,
        package: &str,
        name: &str,
        qos: &QosProfile,
    ) -> Publisher<D> {
        let topic =
            self.node.create_topic(&Name::parse(topic).unwrap(), MessageTypeName::new(package, name), qos);
        self.node.create_publisher(&topic.unwrap(), None).unwrap()
    }

    pub(crate) fn node(&mut self) -> &mut Node {
        &mut self.node
    }

    /// Whether the test goes on.
    pub(crate) fn goes_on(&self) -> bool {
        !self.stop.load(Ordering::Relaxed)
    }

    /// The next new time on `/clock`, ns; none when the test ends.
    pub(crate) fn tick(&mut self) -> Option<i64> {
        while self.goes_on() {
            while let Ok(Some((clock, _))) = self.clock.take() {
                let time = time_nanoseconds(&clock.clock);
                if time != self.last {
                    self.last = time;
                    return Some(time);
                }
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        None
    }

    pub(crate) fn wait_for_the_end(&self) {
        while self.goes_on() {
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

impl Peer {
    /// Starts a node in a domain on a thread of its own.
    pub(crate) fn start(domain: u16, work: impl FnOnce(&mut Hands) + Send + 'static) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let participant = DomainParticipantBuilder::new(domain)
                .with_only_networks([std::net::IpAddr::from([127, 0, 0, 1])])
                .build()
                .unwrap();
            let context = Context::from_domain_participant(participant).unwrap();
            let options = NodeOptions::new().enable_rosout(false);
            let mut node = context.new_node(NodeName::new("/", "peer").unwrap(), options).unwrap();
            let topic = node.create_topic(
                &Name::parse("/clock").unwrap(),
                MessageTypeName::new("rosgraph_msgs", "Clock"),
                &reliable(),
            );
            let clock = node.create_subscription(&topic.unwrap(), None).unwrap();
            work(&mut Hands { node, clock, stop: flag, last: 0 });
        });
        Self { stop, thread: Some(thread) }
    }

    /// A node that answers each tick with this velocity.
    pub(crate) fn answering(domain: u16, linear: f64, angular: f64) -> Self {
        Self::start(domain, move |hands| {
            let commands = hands.publisher::<TwistStamped>("/cmd_vel");
            while let Some(time) = hands.tick() {
                commands.publish(stamped(time, linear, angular)).unwrap();
            }
        })
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let ended = thread.join();
            assert!(ended.is_ok() || std::thread::panicking(), "the peer panicked");
        }
    }
}

pub(crate) fn twist(linear: f64, angular: f64) -> Twist {
    Twist {
        linear: Vector3 { x: linear, ..Vector3::default() },
        angular: Vector3 { z: angular, ..Vector3::default() },
    }
}

pub(crate) fn stamped(time: i64, linear: f64, angular: f64) -> TwistStamped {
    TwistStamped { header: header(time, "base_link"), twist: twist(linear, angular) }
}

/// A task on a path to the east.
pub(crate) fn task(id: &str) -> Task {
    Task {
        id: id.to_owned(),
        vehicle: Vehicle {
            scale: 1.0,
            wheelbase: 3.0,
            wheel_radius: 0.5,
            max_steer_angle: 0.5,
            direction_change_speed: 0.5,
            ..Vehicle::default()
        },
        path: (0..=10).map(|x| Point2 { x: f64::from(x), y: 0.0 }).collect(),
        goal: Point2 { x: 10.0, y: 0.0 },
        control_period: 0.1,
        ..Task::default()
    }
}

/// The observation of a step, 0.1 s after the one before, at 1 m/s.
pub(crate) fn observation(step: u32) -> Observation {
    let mut observation =
        Observation::of(Pose { linear_velocity: Vec3 { x: 1.0, ..Vec3::default() }, ..Pose::default() });
    observation.time = 0.1 * f64::from(step);
    observation
}

pub(crate) fn plugin(options: Options) -> Plugin {
    vb_ros::plugin(options, &Limits::default()).unwrap()
}

pub(crate) fn start(plugin: &Plugin) -> Result<Session, PlannerFault> {
    plugin.start(&task("w001/t00"), LogSink::discard())
}

/// The first fault of a planner that is to drive some steps: its code and its text.
pub(crate) fn fault(options: Options) -> (FaultCode, String) {
    let plugin = plugin(options);
    let told = |fault: PlannerFault| (fault.code(), fault.to_string());
    let mut session = match start(&plugin) {
        Ok(session) => session,
        Err(fault) => return told(fault),
    };
    for step in 0..20 {
        if let Err(fault) = session.step(&observation(step)) {
            return told(fault);
        }
    }
    panic!("20 steps without a fault");
}

/// The command of the harness for a velocity at 1 m/s, as the first of a task.
pub(crate) fn first_command(linear: f64, angular: f64) -> Command {
    vb_ros::Actuator::new(&task("t").vehicle, 0.1).follow(vb_ros::Setpoint::Velocity { linear, angular }, 1.0)
}
