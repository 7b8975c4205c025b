//! Starting processes from a thread that lives as long as the harness.
//!
//! Planner processes ask the system to be killed with the *thread* that started them. Were that a thread that drives
//! tasks, its end would look like the crash of a planner that another thread has taken over.

use std::io;
use std::process::{Child, Command};
use std::sync::Mutex;
use std::sync::{OnceLock, mpsc};

type Job = Box<dyn FnOnce() + Send>;

pub(super) fn spawn(mut command: Command) -> io::Result<Child> {
    static THREAD: OnceLock<Mutex<mpsc::Sender<Job>>> = OnceLock::new();
    let sender = match THREAD.get() {
        Some(sender) => sender,
        None => {
            let (sender, jobs) = mpsc::channel::<Job>();
            std::thread::Builder::new().name("vb-spawner".into()).spawn(move || {
                for job in jobs {
                    job();
                }
            })?;
            // If another thread was faster, its spawner stays, and this one ends with its sender.
            THREAD.get_or_init(|| Mutex::new(sender))
        }
    };
    let (reply, answer) = mpsc::channel();
    let job: Job = Box::new(move || {
        // If nobody waits any more, the process ends with its pipes.
        let _ = reply.send(command.spawn());
    });
    let gone = || io::Error::other("the thread that starts processes is gone");
    vb_files::lock(sender).send(job).map_err(|_| gone())?;
    answer.recv().map_err(|_| gone())?
}
