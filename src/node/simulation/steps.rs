//! Steps of a paused simulation, one at a time: for `step_simulation`, which answers when all are
//! done, and for the action `simulate_steps`, which tells of each and can be cancelled.

use std::rc::Rc;
use std::time::Duration;

use futures::stream::{LocalBoxStream, StreamExt};
use futures::{FutureExt, Stream};
use ros2_client::AsyncActionServer;
use ros2_client::action::{ExecutingGoalHandle, GoalEndStatus, GoalId};

use super::services::{NOT_PAUSED, StepSimulation, done, failed, response};
use super::wire::{StepsFeedback, StepsGoal, StepsResult};
use crate::node::dds::{DdsError, Ros};
use crate::node::service::Asked;
use crate::node::stage::{Stage, State};

/// Why steps ended before they were done.
const INTERRUPTED: &str = "interrupted: the simulation was set to another state";
const BUSY: &str = "steps are being made already";
/// A client asks for the result when its goal is accepted; one that has not asked after all these
/// never will.
const RESULT_WAITS: u32 = 10;
const RESULT_WAIT: Duration = Duration::from_secs(1);

type Server = AsyncActionServer<StepsGoal, StepsResult, StepsFeedback>;
type Handle = ExecutingGoalHandle<StepsGoal>;

/// What the action is asked.
pub enum Request {
    /// So many steps.
    Goal(Handle, u64),
    /// These goals shall end.
    Cancel(Vec<GoalId>),
    /// A result was fetched, or nobody came for it.
    Told,
}

/// The action, and the steps that are being made.
pub struct Steps {
    server: Rc<Server>,
    current: Option<Current>,
}

struct Current {
    asker: Asker,
    completed: u64,
    remaining: u64,
}

enum Asker {
    Service(Asked<StepSimulation>),
    Action(Handle),
}

/// Something still to be told to a client: it ends by itself.
pub type Telling = LocalBoxStream<'static, Request>;

impl Steps {
    /// Opens the action.
    pub fn open(ros: &mut Ros) -> Result<Self, DdsError> {
        Ok(Self { server: Rc::new(ros.simulate_steps()?), current: None })
    }

    /// What the action is asked from now on; it never ends.
    pub fn requests(&self) -> impl Stream<Item = Result<Request, DdsError>> + use<> {
        let goals = futures::stream::unfold(self.server.clone(), async |server| {
            Some((next_goal(&server).await, server))
        });
        let cancels = futures::stream::unfold(self.server.clone(), async |server| {
            Some((next_cancel(&server).await, server))
        });
        futures::stream::select(goals, cancels)
    }

    /// Steps for the service, if time stands still.
    pub fn ask(&mut self, asked: Asked<StepSimulation>, stage: &mut Stage) -> Result<(), DdsError> {
        let steps = asked.request.steps;
        match self.refusal(stage) {
            Some(why) => asked.answer(response(failed(why))),
            None if steps == 0 => asked.answer(response(done())),
            None => {
                self.begin(Asker::Service(asked), steps, stage);
                Ok(())
            }
        }
    }

    /// What the action was asked; what is to be told.
    pub fn act(&mut self, request: Request, stage: &mut Stage) -> Option<Telling> {
        match request {
            Request::Goal(handle, steps) => match self.refusal(stage) {
                Some(why) => Some(self.tell(handle, GoalEndStatus::Aborted, why)),
                None if steps == 0 => Some(self.tell(handle, GoalEndStatus::Succeeded, "")),
                None => {
                    self.begin(Asker::Action(handle), steps, stage);
                    None
                }
            },
            Request::Cancel(goals) => {
                let is_meant = |current: &mut Current| match &current.asker {
                    Asker::Action(handle) => goals.contains(&handle.goal_id()),
                    Asker::Service(_) => false,
                };
                let current = self.current.take_if(is_meant)?;
                stage.time.cancel_steps();
                match current.asker {
                    Asker::Action(handle) => {
                        Some(self.tell(handle, GoalEndStatus::Canceled, "cancelled"))
                    }
                    Asker::Service(_) => None,
                }
            }
            Request::Told => None,
        }
    }

    /// A step was made.
    pub fn made_one(&mut self) -> Result<Option<Telling>, DdsError> {
        let Some(current) = &mut self.current else { return Ok(None) };
        current.completed += 1;
        current.remaining -= 1;
        if let Asker::Action(handle) = &current.asker {
            let feedback = StepsFeedback {
                completed_steps: current.completed,
                remaining_steps: current.remaining,
            };
            // It waits for nothing; feedback that cannot be sent now is of no use later.
            let _ = self.server.publish_feedback(*handle, feedback).now_or_never();
        }
        if current.remaining == 0 { self.end(None) } else { Ok(None) }
    }

    /// Time passes again, or began anew: no more steps.
    pub fn interrupt(&mut self) -> Result<Option<Telling>, DdsError> {
        self.end(Some(INTERRUPTED))
    }

    fn refusal(&self, stage: &Stage) -> Option<&'static str> {
        match (stage.state(), &self.current) {
            (State::Paused, None) => None,
            (State::Paused, Some(_)) => Some(BUSY),
            _ => Some(NOT_PAUSED),
        }
    }

    fn begin(&mut self, asker: Asker, steps: u64, stage: &mut Stage) {
        self.current = Some(Current { asker, completed: 0, remaining: steps });
        stage.time.step(steps);
    }

    fn end(&mut self, why: Option<&'static str>) -> Result<Option<Telling>, DdsError> {
        let Some(current) = self.current.take() else { return Ok(None) };
        let verdict = why.map_or_else(done, failed);
        match current.asker {
            Asker::Service(asked) => asked.answer(response(verdict)).map(|()| None),
            Asker::Action(handle) => {
                let status = match why {
                    None => GoalEndStatus::Succeeded,
                    Some(_) => GoalEndStatus::Aborted,
                };
                Ok(Some(self.tell(handle, status, why.unwrap_or_default())))
            }
        }
    }

    /// Hands over a result when the client comes for it.
    fn tell(&self, handle: Handle, status: GoalEndStatus, why: &'static str) -> Telling {
        let server = self.server.clone();
        let told = async move {
            for _ in 0..RESULT_WAITS {
                let verdict = if why.is_empty() { done() } else { failed(why) };
                let result = StepsResult { result: verdict };
                let sent = server.send_result_response(handle, status, result);
                if tokio::time::timeout(RESULT_WAIT, sent).await.is_ok() {
                    break;
                }
            }
            Request::Told
        };
        futures::stream::once(told).boxed_local()
    }
}

/// A goal, accepted and begun: whether time stands still is known to the loop.
async fn next_goal(server: &Server) -> Result<Request, DdsError> {
    let undecodable = |error: ros2_client::ReadError| DdsError::Undecodable(error.to_string());
    let unsent = |error| DdsError::Send(format!("{error:?}"));
    let new = server.receive_new_goal().await.map_err(undecodable)?;
    let steps = server.get_new_goal(new).map_or(0, |goal| goal.steps);
    let accepted = server.accept_goal(new).await.map_err(unsent)?;
    let handle = server.start_executing_goal(accepted).await.map_err(unsent)?;
    Ok(Request::Goal(handle, steps))
}

async fn next_cancel(server: &Server) -> Result<Request, DdsError> {
    let undecodable = |error: ros2_client::ReadError| DdsError::Undecodable(error.to_string());
    let cancel = server.receive_cancel_request().await.map_err(undecodable)?;
    let answered = server.respond_to_cancel_requests(&cancel, cancel.goals()).await;
    answered.map_err(|error| DdsError::Send(error.to_string()))?;
    Ok(Request::Cancel(cancel.goals().collect()))
}
