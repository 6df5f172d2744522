//! The running node: its topics and services, and what happens on them.
//!
//! One thread serves DDS and never waits for work: frames and requests go to the worker's inbox, answers come back.

use super::calibrator::Answer;
use super::messages::{Image, TriggerRequest, TriggerResponse};
use super::newcomer::Newcomer;
use super::parameter_services::{ParameterRequest, ParameterServices, requests, send, server};
use super::parameter_store::ParameterStore;
use super::publishers::{EntityError, Publishers, dds_name};
use super::qos;
use super::remap::Names;
use super::start::NodeError;
use super::worker::{Command, Reply, Worker, WorkerInbox};
use futures::channel::mpsc;
use futures::channel::oneshot;
use futures::stream::{self, StreamExt};
use ros2_client::{Context, MessageTypeName, RmwRequestId, Server, Subscription};
use std::path::PathBuf;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long the worker is waited for when the node leaves.
const PATIENCE: Duration = Duration::from_secs(1);

/// The three services of the node itself.
#[derive(Debug, Clone, Copy)]
enum Service {
    Calibrate,
    Reset,
    Save,
}

/// What can happen.
enum Event {
    Frame(Image),
    Request(Service, RmwRequestId),
    Parameters(ParameterRequest),
    /// The worker has an answer for a caller.
    Answered(Service, RmwRequestId, Answer),
    /// The process is asked to end.
    End,
    /// The worker's thread is gone, which it should not be.
    WorkerEnded,
}

/// The worker's thread, told to end and waited for when it goes.
struct Crew {
    inbox: Arc<WorkerInbox>,
    thread: Option<JoinHandle<()>>,
}

impl Crew {
    /// Starts the worker; the receiver is done when its thread has ended, however that came.
    fn start(
        worker: Worker,
        inbox: Arc<WorkerInbox>,
    ) -> std::io::Result<(Self, oneshot::Receiver<()>)> {
        let (alive, ended) = oneshot::channel();
        let thread = std::thread::Builder::new()
            .name("worker".to_owned())
            .spawn(move || {
                let _alive = alive;
                worker.run();
            })?;
        let thread = Some(thread);
        Ok((Self { inbox, thread }, ended))
    }
}

impl Drop for Crew {
    fn drop(&mut self) {
        self.inbox.close();
        let Some(thread) = self.thread.take() else {
            return;
        };
        let end = Instant::now() + PATIENCE;
        while !thread.is_finished() && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(2));
        }
        if thread.is_finished() {
            // what it panicked with has been printed
            let _ = thread.join();
        }
    }
}

/// Serves until the end is asked for; everything made here is gone when it returns.
pub fn serve(
    context: &Context,
    node: &mut Newcomer,
    names: &Names,
    mut store: ParameterStore,
    asked_to_end: oneshot::Receiver<()>,
) -> Result<(), NodeError> {
    let publishers = Publishers::open(node, names)?;
    let parameters = ParameterServices::open(node, names)?;
    const TRIGGER: (&str, &str) = ("std_srvs", "Trigger");
    type Trigger = Server<TriggerRequest, TriggerResponse>;
    let calibrate: Trigger = server(node, names, "~/calibrate", TRIGGER)?;
    let reset: Trigger = server(node, names, "~/reset", TRIGGER)?;
    let save: Trigger = server(node, names, "~/save", TRIGGER)?;
    let topic = names.topic("image").map_err(EntityError::from)?;
    let frames = subscribe(node, &topic)?;
    let inbox = Arc::new(WorkerInbox::default());
    let configuration = store.configuration().clone();
    tracing::info!(
        "{} waits for frames on {topic}, board {} x {} from {}",
        names.node().fully_qualified(),
        configuration.board.rows(),
        configuration.board.columns(),
        configuration.settings.board_file.display()
    );
    let worker = Worker::new(
        configuration,
        &topic,
        Arc::clone(&inbox),
        publishers,
        context.clone(),
        ros_home(),
    );
    let (answers, answered) = mpsc::unbounded();
    let (crew, worker_ended) = Crew::start(worker, Arc::clone(&inbox))?;
    let triggered =
        |service, server| requests(server).map(move |(id, _)| Event::Request(service, id));
    let mut events = stream::select_all([
        stream::once(asked_to_end).map(|_| Event::End).boxed_local(),
        stream::once(worker_ended)
            .map(|_| Event::WorkerEnded)
            .boxed_local(),
        answered
            .map(|(service, id, answer)| Event::Answered(service, id, answer))
            .boxed_local(),
        triggered(Service::Calibrate, &calibrate).boxed_local(),
        triggered(Service::Reset, &reset).boxed_local(),
        triggered(Service::Save, &save).boxed_local(),
        parameters.requests().map(Event::Parameters).boxed_local(),
        received(&frames).map(Event::Frame).boxed_local(),
    ]);
    loop {
        match futures::executor::block_on(events.next()) {
            Some(Event::Frame(image)) => inbox.put_frame(image),
            Some(Event::Request(service, id)) => {
                let answers = answers.clone();
                let reply: Reply = Box::new(move |answer| {
                    // nobody takes answers while the node leaves
                    let _ = answers.unbounded_send((service, id, answer));
                });
                inbox.put_command(match service {
                    Service::Calibrate => Command::Calibrate(reply),
                    Service::Reset => Command::Reset(reply),
                    Service::Save => Command::Save(reply),
                });
            }
            Some(Event::Answered(service, id, answer)) => {
                let server = match service {
                    Service::Calibrate => &calibrate,
                    Service::Reset => &reset,
                    Service::Save => &save,
                };
                send(server, id, response(answer));
            }
            Some(Event::Parameters(request)) => {
                let taken = parameters.answer(request, &mut store);
                if taken.is_empty() {
                    continue;
                }
                for parameter in taken {
                    tracing::info!("parameter {} was set", parameter.name);
                    // for /parameter_events; the value has been checked
                    if let Err(reason) = node
                        .introduced()
                        .set_parameter(&parameter.name, parameter.value)
                    {
                        tracing::warn!("{reason}");
                    }
                }
                inbox.put_command(Command::Configure(Box::new(store.configuration().clone())));
            }
            Some(Event::End) => {
                tracing::info!("asked to end");
                break;
            }
            Some(Event::WorkerEnded) | None => return Err(NodeError::Worker),
        }
    }
    drop(events);
    drop(crew);
    Ok(())
}

fn response(answer: Answer) -> TriggerResponse {
    let (success, message) = match answer {
        Answer::Done(text) => (true, text),
        Answer::Refused(text) => (false, text),
    };
    TriggerResponse { success, message }
}

fn subscribe(newcomer: &mut Newcomer, topic: &str) -> Result<Subscription<Image>, NodeError> {
    let kind = MessageTypeName::new("sensor_msgs", "Image");
    let node = newcomer.node();
    let dds_topic = node.create_topic(&dds_name(topic)?, kind, &qos::frames())?;
    Ok(node.create_subscription(&dds_topic, Some(qos::frames()))?)
}

/// Frames as they come; what is no image at all is said in the log.
fn received(frames: &Subscription<Image>) -> impl futures::Stream<Item = Image> + '_ {
    frames.async_stream().filter_map(|message| {
        let image = message
            .inspect_err(|error| tracing::warn!("a frame that cannot be read: {error}"))
            .ok()
            .map(|(image, _)| image);
        std::future::ready(image)
    })
}

/// Where ROS keeps a user's files.
fn ros_home() -> PathBuf {
    match std::env::var_os("ROS_HOME") {
        Some(folder) if !folder.is_empty() => folder.into(),
        // without a home the current folder is all there is
        _ => std::env::home_dir().unwrap_or_default().join(".ros"),
    }
}
