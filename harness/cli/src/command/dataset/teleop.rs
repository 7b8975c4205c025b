//! `vb-harness dataset teleop`.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Args;
use serde::Serialize;
use serde_json::json;
use vb_dataset::{DatasetWriter, Ending, Kind, Making};
use vb_score::{Outcome, Rules};
use vb_sdk::metadata::Need;
use vb_teleop::{Ask, CONTROL_PERIOD, Live, PersonDriver, Server, Wheel};
use vb_trial::Wants;
use vb_world::TaskId;

use super::finish;
use super::scene::{Scene, SceneArgs};
use crate::args::{JobsArgs, RULES};
use crate::command::{replay, run, suite};
use crate::error::CliError;
use crate::output;

#[cfg(feature = "teleop")]
#[derive(Debug, Args)]
pub(crate) struct TeleopArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Tasks to choose from, e.g. w001-w004,w007/t03 or elevation=high,terrain=rigid (different keys must hold together, values of one key
    /// are alternatives); default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    /// Port on this machine; 0 for a free port
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    pub(crate) port: u16,
    /// Don't open the web page in the browser
    #[arg(long)]
    pub(crate) no_browser: bool,
}

/// How long it is waited for the page before Ctrl-C is looked for.
const LOOK: Duration = Duration::from_millis(50);

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Serving { address: &'a str },
    Episode { task: &'a TaskId, outcome: &'a str, frames: usize, episodes: usize },
}

pub(super) fn teleop(args: &TeleopArgs) -> Result<(), CliError> {
    let rules = Rules::resolve(RULES).map_err(CliError::internal)?;
    let scene = Scene::new(&args.scene, rules)?;
    let tasks = suite::select(&scene.worlds, args.tasks.as_deref())?;
    let layout = scene.layout(false, true);
    let writer = scene.writer(scene.header(Kind::Teleop, layout))?;
    let cancel = run::stop_on_ctrl_c()?;
    let names: Vec<String> = tasks.iter().map(ToString::to_string).collect();
    let data = json!({"tasks": names, "episodes": writer.episodes()});
    let wheel = Wheel::default();
    let page = vb_replay::live_page("Drive", &data);
    let server = Server::start(page, args.port, wheel.clone()).map_err(CliError::output)?;
    let address = server.address();
    if args.scene.format.is_json() {
        output::json(&Message::Serving { address: &address });
    } else {
        output::say(&format!("drive at {address} (Ctrl-C ends it)"));
    }
    if !args.no_browser {
        replay::open(std::path::Path::new(&address));
    }
    let mut seat = Seat { scene: &scene, writer, server, wheel, tasks, json: args.scene.format.is_json() };
    seat.serve(&cancel)?;
    let Seat { writer, .. } = seat;
    if writer.episodes() == 0 {
        return Err(CliError::interrupted("stopped without an episode, so there is no dataset"));
    }
    finish(writer, true, &args.scene.out, args.scene.format.get())
}

/// Where the person sits.
struct Seat<'a> {
    scene: &'a Scene<'a>,
    writer: DatasetWriter,
    server: Server,
    wheel: Wheel,
    tasks: Vec<TaskId>,
    json: bool,
}

impl Seat<'_> {
    /// Does what the page asks for, until it is cancelled.
    fn serve(&mut self, cancel: &AtomicBool) -> Result<(), CliError> {
        let mut next = None;
        while !cancel.load(Ordering::Relaxed) {
            match next.take().or_else(|| self.server.ask(LOOK)) {
                // Where somebody may start is shown before they do.
                Some(Ask::Hello) => self.show(&self.tasks[0].clone(), false)?,
                Some(Ask::Start(name)) => match self.tasks.iter().find(|t| **t == *name).cloned() {
                    Some(task) => next = self.drive(&task, cancel)?,
                    None => self.server.tell(&json!({"error": format!("there is no task {name}")})),
                },
                Some(Ask::Reset | Ask::Gone) | None => {}
            }
        }
        Ok(())
    }

    /// Sends the page a task's world and vehicle.
    fn show(&self, task: &TaskId, driving: bool) -> Result<(), CliError> {
        let setting = &self.scene.setting;
        let world = self.scene.worlds.load_world(task.world())?;
        let world = Arc::new(world.at_scale(setting.scale));
        let Some(found) = world.task(task.task()) else { return Ok(()) };
        let radius = setting.rules.goal_radius(setting.scale);
        let name = &self.scene.worlds.meta().name;
        let scene = vb_replay::live_scene(&world, found, name, radius, setting.model.spec());
        self.server.tell(&json!({"scene": scene, "driving": driving}));
        Ok(())
    }

    /// Lets the person drive a task, and keeps the episode unless it is given up; what the page asked for meanwhile.
    fn drive(&mut self, task: &TaskId, cancel: &AtomicBool) -> Result<Option<Ask>, CliError> {
        self.show(task, true)?;
        let wants = Wants {
            name: "person".to_owned(),
            control_period: CONTROL_PERIOD,
            needs: Need::DEFAULT.to_vec(),
            params: Vec::new(),
        };
        let end = Arc::new(AtomicBool::new(false));
        let (features, index) = (self.writer.features().to_vec(), self.writer.next_drive());
        let motion = self.server.motion();
        let mut driver = PersonDriver::new(self.wheel.clone(), Arc::clone(&end));
        let making: Making<'_> = self.scene.making(&end, JobsArgs { jobs: Some(1) });
        let model = &self.scene.setting.model;
        // The person drives on a thread of its own, while this one listens to the page.
        let (episode, asked) = std::thread::scope(|scope| {
            let driving = scope.spawn(|| {
                let mut live = Live::new(model, motion);
                making.by_hand(&features, task, &wants, &mut driver, &mut live, index)
            });
            let mut asked = None;
            while !driving.is_finished() {
                let ask = self.server.ask(LOOK);
                if matches!(ask, Some(Ask::Reset | Ask::Start(_) | Ask::Gone)) {
                    asked = ask;
                }
                if asked.is_some() || cancel.load(Ordering::Relaxed) {
                    end.store(true, Ordering::Relaxed);
                }
            }
            (driving.join(), asked)
        });
        let episode = episode.map_err(|_| CliError::internal("the drive panicked; please report it"))?;
        let Some(episode) = episode? else { return Ok(asked) };
        // Who resets, or starts anew on the way, gives the drive up; who closes the page doesn't.
        let given_up =
            episode.info.outcome == Ending::ByDriver && matches!(asked, Some(Ask::Reset | Ask::Start(_)));
        if !given_up && episode.frames > 0 {
            self.writer.add(&episode).and_then(|()| self.writer.save())?;
        }
        let episodes = self.writer.episodes();
        let info = &episode.info;
        let text = if given_up {
            "discarded".to_owned()
        } else {
            format!("{} after {:.1} s: {}", info.outcome.name().replace('_', " "), info.time_s, info.reason)
        };
        let ended = json!({"text": text, "success": info.outcome == Ending::Decided(Outcome::Success)});
        self.server.tell(&json!({"ended": ended, "episodes": episodes}));
        let frames = episode.frames;
        if self.json {
            output::json(&Message::Episode { task, outcome: info.outcome.name(), frames, episodes });
        } else {
            output::note(&format!("{task}: {text}; {episodes} episodes stored"));
        }
        Ok(asked.filter(|a| matches!(a, Ask::Start(_))))
    }
}
