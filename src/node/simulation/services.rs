//! A call on the stage for each service, and its answer; refusals say why, with the standard's
//! code.

use std::time::Instant;

use glam::DVec2;

use super::entities;
use super::wire::{
    BoundsResponse, EntitiesResponse, EntitiesStatesResponse, EntityInfoResponse, EntityRequest,
    EntityStateResponse, FEATURES, FeaturesResponse, FiltersRequest, LoadRequest, Nothing,
    ResetRequest, Resource, Result as Verdict, ResultResponse, SetEntityStateRequest,
    SimulationState, SimulatorFeatures, SpawnManyRequest, SpawnManyResponse, SpawnRequest,
    SpawnResponse, SpawnResult, StateRequest, StateResponse, StepRequest, WorldResource,
    WorldResponse, WorldsRequest, WorldsResponse, code, scope, state,
};
use crate::messages::{Header, Pose, Time, Twist, Vector3};
use crate::node::dds::DdsError;
use crate::node::names::check_absolute;
use crate::node::service::{Asked, RosService, services};
use crate::node::stage::{NotAdded, Scope, Stage, State};
use crate::scene::{Puck, Scene, file, shipped};
use crate::world::NotDone;

services! { "simulation_interfaces":
    GetSimulatorFeatures Nothing => FeaturesResponse, "get_simulator_features";
    GetSimulationState Nothing => StateResponse, "get_simulation_state";
    SetSimulationState StateRequest => ResultResponse, "set_simulation_state";
    StepSimulation StepRequest => ResultResponse, "step_simulation";
    ResetSimulation ResetRequest => ResultResponse, "reset_simulation";
    GetEntities FiltersRequest => EntitiesResponse, "get_entities";
    GetEntityState EntityRequest => EntityStateResponse, "get_entity_state";
    GetEntitiesStates FiltersRequest => EntitiesStatesResponse, "get_entities_states";
    SetEntityState SetEntityStateRequest => ResultResponse, "set_entity_state";
    GetEntityInfo EntityRequest => EntityInfoResponse, "get_entity_info";
    GetEntityBounds EntityRequest => BoundsResponse, "get_entity_bounds";
    SpawnEntity SpawnRequest => SpawnResponse, "spawn_entity";
    SpawnEntities SpawnManyRequest => SpawnManyResponse, "spawn_entities";
    DeleteEntity EntityRequest => ResultResponse, "delete_entity";
    LoadWorld LoadRequest => WorldResponse, "load_world";
    UnloadWorld Nothing => ResultResponse, "unload_world";
    GetCurrentWorld Nothing => WorldResponse, "get_current_world";
    GetAvailableWorlds WorldsRequest => WorldsResponse, "get_available_worlds";
}

/// What the loop has to do besides.
#[derive(Debug, Default, PartialEq)]
pub struct Effect {
    /// Pucks came or went: topics with their names must follow.
    pub pucks: bool,
    /// Time was set back or stands still: say so at once.
    pub time: bool,
    /// The node is to end.
    pub quit: bool,
}

const PUCKS: Effect = Effect { pucks: true, time: false, quit: false };
const TIME: Effect = Effect { pucks: false, time: true, quit: false };
const NEW_WORLD: Effect = Effect { pucks: true, time: true, quit: false };

/// Answers a request; steps are left to who counts them.
pub fn answer(request: &Request, stage: &mut Stage) -> (Effect, Result<(), DdsError>) {
    let now = Instant::now();
    match request {
        Request::GetSimulatorFeatures(asked) => tell(asked, features()),
        Request::GetSimulationState(asked) => tell(asked, simulation_state(stage)),
        Request::SetSimulationState(asked) => {
            act(asked, set_state(stage, asked.request.state.state, now))
        }
        // Asked for before it was known whether time stands still.
        Request::StepSimulation(asked) => tell(asked, response(failed(NOT_PAUSED))),
        Request::ResetSimulation(asked) => act(asked, reset(stage, asked.request.scope, now)),
        Request::GetEntities(asked) => {
            let refuse = |result| EntitiesResponse { result, entities: Vec::new() };
            tell_many(asked, get_entities(stage, &asked.request), refuse)
        }
        Request::GetEntityState(asked) => tell(asked, entity_state(stage, &asked.request)),
        Request::GetEntitiesStates(asked) => {
            let refuse = |result| EntitiesStatesResponse { result, ..Default::default() };
            tell_many(asked, entities_states(stage, &asked.request), refuse)
        }
        Request::SetEntityState(asked) => {
            tell(asked, response(set_entity_state(stage, &asked.request)))
        }
        Request::GetEntityInfo(asked) => tell(asked, entity_info(stage, &asked.request)),
        Request::GetEntityBounds(asked) => tell(asked, entity_bounds(stage, &asked.request)),
        Request::SpawnEntity(asked) => {
            let SpawnResult { result, entity_name } = spawn(stage, &asked.request);
            (PUCKS, asked.answer(SpawnResponse { result, entity_name }))
        }
        Request::SpawnEntities(asked) => {
            let told = spawn_many(stage, &asked.request);
            let result = told.result.clone();
            let refused = first_refused(&told.results);
            // They were spawned, whether or not all their names fit into the answer.
            let refuse = |why: Verdict| {
                let mut said = vec![result.error_message, refused, why.error_message];
                said.retain(|part| !part.is_empty());
                let result = Verdict { result: result.result, error_message: said.join("; ") };
                SpawnManyResponse { result, results: Vec::new() }
            };
            (PUCKS, tell_many(asked, told, refuse).1)
        }
        Request::DeleteEntity(asked) => {
            (PUCKS, asked.answer(response(delete(stage, &asked.request.entity))))
        }
        Request::LoadWorld(asked) => (NEW_WORLD, asked.answer(load(stage, &asked.request, now))),
        Request::UnloadWorld(asked) => (NEW_WORLD, asked.answer(response(unload(stage, now)))),
        Request::GetCurrentWorld(asked) => tell(asked, current_world(stage)),
        Request::GetAvailableWorlds(asked) => tell(asked, worlds(&asked.request)),
    }
}

/// Why there are no steps.
pub const NOT_PAUSED: &str = "the simulation is not paused: set_simulation_state to PAUSED first";
const NO_WORLD: &str = "no world is loaded: load_world first";

fn tell<S: RosService>(asked: &Asked<S>, told: S::Response) -> (Effect, Result<(), DdsError>) {
    (Effect::default(), asked.answer(told))
}

/// The same, or that it does not fit.
fn tell_many<S: RosService>(
    asked: &Asked<S>,
    told: S::Response,
    refuse: impl FnOnce(Verdict) -> S::Response,
) -> (Effect, Result<(), DdsError>) {
    let answered = match asked.answer(told) {
        Err(error @ DdsError::TooLarge(_)) => asked.answer(refuse(failed(error))),
        answered => answered,
    };
    (Effect::default(), answered)
}

fn act<S: RosService<Response = ResultResponse>>(
    asked: &Asked<S>,
    (effect, verdict): (Effect, Verdict),
) -> (Effect, Result<(), DdsError>) {
    (effect, asked.answer(response(verdict)))
}

/// The verdict as a response that holds nothing else.
pub fn response(result: Verdict) -> ResultResponse {
    ResultResponse { result }
}

/// It was done.
pub fn done() -> Verdict {
    Verdict { result: code::OK, error_message: String::new() }
}

/// It was not done, for a reason that has no code of its own.
pub fn failed(why: impl ToString) -> Verdict {
    refused(code::OPERATION_FAILED, why)
}

fn refused(code: u8, why: impl ToString) -> Verdict {
    Verdict { result: code, error_message: why.to_string() }
}

fn verdict(done_or_not: Result<(), Verdict>) -> Verdict {
    done_or_not.map_or_else(|refused| refused, |()| done())
}

fn features() -> FeaturesResponse {
    FeaturesResponse {
        features: SimulatorFeatures {
            features: FEATURES.to_vec(),
            spawn_formats: vec!["yaml".to_owned()],
            custom_info:
                "carom: a puck is spawned from a resource_string in YAML with the keys of \
                          a scene's puck: radius (required), mass, velocity, colour, driven, name; \
                          a step is a period of publish_rate_hz"
                    .to_owned(),
        },
    }
}

fn simulation_state(stage: &Stage) -> StateResponse {
    let state = match stage.state() {
        State::Stopped => state::STOPPED,
        State::Playing => state::PLAYING,
        State::Paused => state::PAUSED,
        State::NoWorld => state::NO_WORLD,
    };
    StateResponse { state: SimulationState { state }, result: done() }
}

fn set_state(stage: &mut Stage, wanted: u8, now: Instant) -> (Effect, Verdict) {
    let already = || refused(code::ALREADY_IN_TARGET_STATE, "it is in that state already");
    let nothing = |verdict| (Effect::default(), verdict);
    match (stage.state(), wanted) {
        (_, state::QUITTING) => (Effect { quit: true, ..Effect::default() }, done()),
        (State::NoWorld, _) => nothing(refused(code::INCORRECT_STATE, NO_WORLD)),
        (State::Stopped, state::STOPPED)
        | (State::Playing, state::PLAYING)
        | (State::Paused, state::PAUSED) => nothing(already()),
        (_, state::PLAYING) => {
            stage.play(now);
            (TIME, done())
        }
        (_, state::PAUSED) => {
            stage.pause();
            (TIME, done())
        }
        (_, state::STOPPED) => match stage.stop(now) {
            Ok(()) => (NEW_WORLD, done()),
            Err(why) => nothing(refused(code::STATE_TRANSITION_ERROR, why)),
        },
        (_, other) => {
            let why =
                format!("state {other} cannot be asked for: STOPPED, PLAYING, PAUSED, QUITTING");
            nothing(refused(code::INCORRECT_TRANSITION, why))
        }
    }
}

fn reset(stage: &mut Stage, wanted: u8, now: Instant) -> (Effect, Verdict) {
    if stage.state() == State::NoWorld {
        return (Effect::default(), refused(code::INCORRECT_STATE, NO_WORLD));
    }
    let wanted = if wanted == 0 { scope::ALL } else { wanted };
    if wanted != scope::ALL && wanted & !(scope::TIME | scope::STATE | scope::SPAWNED) != 0 {
        let why = format!("scope {wanted} is none: a sum of 1 (time), 2 (state), 4 (spawned)");
        return (Effect::default(), failed(why));
    }
    let has = |bit: u8| wanted & bit != 0;
    let scope =
        Scope { time: has(scope::TIME), state: has(scope::STATE), spawned: has(scope::SPAWNED) };
    match stage.reset(scope, now) {
        Ok(()) => (NEW_WORLD, done()),
        Err(why) => (Effect::default(), failed(why)),
    }
}

fn named<'a>(stage: &'a Stage, name: &str) -> Result<&'a Puck, Verdict> {
    let missing = || refused(code::NOT_FOUND, format!("there is no entity `{name}`"));
    stage.puck(name).ok_or_else(missing)
}

fn header(stage: &Stage) -> Header {
    let time = stage.world().arena().map_or(0.0, |arena| arena.now());
    let frame_id = stage.scene().node.frame_id.clone();
    Header { stamp: Time::from_seconds(time), frame_id }
}

fn get_entities(stage: &Stage, request: &FiltersRequest) -> EntitiesResponse {
    match entities::filtered(stage, &request.filters) {
        Ok(found) => {
            let entities = found.iter().map(|(puck, _)| puck.name.clone()).collect();
            EntitiesResponse { result: done(), entities }
        }
        Err(why) => EntitiesResponse { result: failed(why), entities: Vec::new() },
    }
}

fn entities_states(stage: &Stage, request: &FiltersRequest) -> EntitiesStatesResponse {
    match entities::filtered(stage, &request.filters) {
        Ok(found) => {
            let header = header(stage);
            let (entities, states) = found
                .iter()
                .map(|(puck, disc)| (puck.name.clone(), entities::state(header.clone(), disc)))
                .unzip();
            EntitiesStatesResponse { result: done(), entities, states }
        }
        Err(why) => EntitiesStatesResponse { result: failed(why), ..Default::default() },
    }
}

fn entity_state(stage: &Stage, request: &EntityRequest) -> EntityStateResponse {
    let id = named(stage, &request.entity).map(|puck| puck.disc.id);
    let found = id.and_then(|id| {
        let pucks = stage.now().into_iter();
        pucks.map(|(_, disc)| disc).find(|disc| disc.id == id).ok_or_else(|| failed("it is gone"))
    });
    match found {
        Ok(disc) => {
            let state = entities::state(header(stage), &disc);
            EntityStateResponse { result: done(), state }
        }
        Err(result) => EntityStateResponse { result, ..Default::default() },
    }
}

fn entity_info(stage: &Stage, request: &EntityRequest) -> EntityInfoResponse {
    match named(stage, &request.entity) {
        Ok(puck) => EntityInfoResponse { result: done(), info: entities::info(stage, puck) },
        Err(result) => EntityInfoResponse { result, ..Default::default() },
    }
}

fn entity_bounds(stage: &Stage, request: &EntityRequest) -> BoundsResponse {
    match named(stage, &request.entity) {
        Ok(puck) => BoundsResponse { result: done(), bounds: entities::bounds_of(puck) },
        Err(result) => BoundsResponse { result, ..Default::default() },
    }
}

fn set_entity_state(stage: &mut Stage, request: &SetEntityStateRequest) -> Verdict {
    verdict((|| {
        let puck = named(stage, &request.entity)?;
        let id = puck.disc.id;
        let state = &request.state;
        let at = place(stage, &state.header.frame_id, &state.pose)
            .map_err(|why| refused(code::STATE_INVALID_POSE, why))?;
        let velocity = flat(&state.twist.linear);
        if state.twist.angular != Vector3::default() || state.acceleration != Twist::default() {
            return Err(failed("a puck neither turns nor accelerates: leave those at 0"));
        }
        if puck.disc.mass.is_infinite() && !puck.driven && velocity != DVec2::ZERO {
            return Err(failed("a fixed puck has no velocity"));
        }
        stage.place(id, at, velocity).map_err(|why| match why {
            NotDone::OutsideWalls | NotDone::Overlaps(_) | NotDone::Defect(_) => {
                refused(code::STATE_INVALID_POSE, why)
            }
            _ => failed(why),
        })
    })())
}

/// The place that a pose names, or why it names none.
fn place(stage: &Stage, frame_id: &str, pose: &Pose) -> Result<DVec2, String> {
    let own = &stage.scene().node.frame_id;
    if !(frame_id.is_empty() || frame_id == "world" || frame_id == own) {
        return Err(format!("frame `{frame_id}` is not known: `{own}`, or leave it empty"));
    }
    let q = &pose.orientation;
    let length = q.x.mul_add(q.x, q.y * q.y) + q.z.mul_add(q.z, q.w * q.w);
    // All zeros is what a client sends that thinks of no orientation.
    if length != 0.0 && (length - 1.0).abs().partial_cmp(&1e-3).is_none_or(|o| o.is_gt()) {
        return Err(format!("the quaternion's length is {}, must be 1", length.sqrt()));
    }
    let at = flat(&pose.position);
    if at.is_finite() { Ok(at) } else { Err("the position must be finite".to_owned()) }
}

fn flat(vector: &Vector3) -> DVec2 {
    DVec2::new(vector.x, vector.y)
}

fn spawn(stage: &mut Stage, request: &SpawnRequest) -> SpawnResult {
    match spawn_or_not(stage, request) {
        Ok(entity_name) => SpawnResult { result: done(), entity_name },
        Err(result) => SpawnResult { result, entity_name: String::new() },
    }
}

fn spawn_or_not(stage: &mut Stage, request: &SpawnRequest) -> Result<String, Verdict> {
    if stage.state() == State::NoWorld {
        return Err(refused(code::INCORRECT_STATE, NO_WORLD));
    }
    let Resource { uri, resource_string } = &request.entity_resource;
    if !uri.is_empty() {
        let why = format!("uri `{uri}`: give the puck as resource_string, in YAML");
        return Err(refused(code::UNSUPPORTED_FORMAT, why));
    }
    if resource_string.trim().is_empty() {
        let why = "give the puck as resource_string, such as `{radius: 0.1}`";
        return Err(refused(code::NO_RESOURCE, why));
    }
    if !request.entity_namespace.is_empty() {
        let space = format!("/{}", request.entity_namespace.trim_start_matches('/'));
        check_absolute(&space).map_err(|why| refused(code::NAMESPACE_INVALID, why))?;
    }
    let mut puck = file::parse_puck(resource_string, "resource_string")
        .map_err(|why| refused(code::RESOURCE_PARSE_ERROR, why))?;
    if !request.name.is_empty() {
        puck.name.clone_from(&request.name);
    }
    let stamped = &request.initial_pose;
    puck.disc.position = place(stage, &stamped.header.frame_id, &stamped.pose)
        .map_err(|why| refused(code::INVALID_POSE, why))?;
    puck.namespace = request.entity_namespace.trim_matches('/').to_owned();
    stage.add(puck, request.allow_renaming).map_err(|why| match why {
        NotAdded::Taken(_) => refused(code::NAME_NOT_UNIQUE, why),
        NotAdded::Name(_) => refused(code::NAME_INVALID, why),
        NotAdded::NotDone(NotDone::OutsideWalls | NotDone::Overlaps(_) | NotDone::Defect(_)) => {
            refused(code::INVALID_POSE, why)
        }
        NotAdded::NotDone(_) => failed(why),
    })
}

fn spawn_many(stage: &mut Stage, request: &SpawnManyRequest) -> SpawnManyResponse {
    let results: Vec<SpawnResult> =
        request.spawn_requests.iter().map(|request| spawn(stage, request)).collect();
    let bad = results.iter().filter(|spawned| spawned.result.result != code::OK).count();
    let result = match bad {
        0 => done(),
        _ => refused(code::ENTITIES_SPAWN_FAILED, format!("{bad} of {} failed", results.len())),
    };
    SpawnManyResponse { result, results }
}

/// The first that were not spawned, by their places from 0, with the reasons, cut to a few lines.
fn first_refused(results: &[SpawnResult]) -> String {
    const MOST: usize = 5;
    let bad = results.iter().enumerate().filter(|(_, spawned)| spawned.result.result != code::OK);
    let told = |(place, spawned): (usize, &SpawnResult)| {
        let why: String = spawned.result.error_message.chars().take(100).collect();
        format!("number {place}: {why}")
    };
    bad.take(MOST).map(told).collect::<Vec<_>>().join("; ")
}

fn delete(stage: &mut Stage, name: &str) -> Verdict {
    let id = named(stage, name).map(|puck| puck.disc.id);
    verdict(id.and_then(|id| stage.remove(id).map_err(failed)))
}

fn load(stage: &mut Stage, request: &LoadRequest, now: Instant) -> WorldResponse {
    let Resource { uri, resource_string } = &request.world_resource;
    let scene = match (uri.as_str(), resource_string.trim()) {
        ("", "") => Err(refused(code::WORLD_NO_RESOURCE, "name a scene, or give one as text")),
        ("", text) => file::parse(text, "resource_string")
            .map_err(|error| refused(code::WORLD_PARSE_ERROR, error)),
        (uri, _) => match uri.split_once("://") {
            None | Some(("file", _)) => {
                let path = uri.strip_prefix("file://").unwrap_or(uri);
                let scene = Scene::load_without_waiting(path);
                scene.map_err(|error| refused(code::WORLD_PARSE_ERROR, error))
            }
            Some((scheme, _)) => {
                let why = format!("uri `{scheme}://`: a path or the name of a shipped scene");
                Err(refused(code::WORLD_UNSUPPORTED_FORMAT, why))
            }
        },
    };
    match scene {
        Ok(scene) => {
            let otherwise = stage.does_otherwise(&scene).join(", ");
            if !otherwise.is_empty() {
                tracing::warn!("load_world: the node keeps its own {otherwise}, not the scene's");
            }
            stage.load(scene, now);
            WorldResponse { result: done(), world: world(&stage.scene().name, uri) }
        }
        Err(result) => WorldResponse { result, ..Default::default() },
    }
}

fn unload(stage: &mut Stage, now: Instant) -> Verdict {
    if stage.state() == State::NoWorld {
        return refused(code::NO_WORLD_LOADED, NO_WORLD);
    }
    stage.unload(now);
    done()
}

fn world(name: &str, uri: &str) -> WorldResource {
    WorldResource {
        name: name.to_owned(),
        world_resource: Resource { uri: uri.to_owned(), resource_string: String::new() },
        ..Default::default()
    }
}

fn current_world(stage: &Stage) -> WorldResponse {
    if stage.state() == State::NoWorld {
        let result = refused(code::NO_WORLD_LOADED, NO_WORLD);
        return WorldResponse { result, ..Default::default() };
    }
    WorldResponse { result: done(), world: world(&stage.scene().name, "") }
}

fn worlds(request: &WorldsRequest) -> WorldsResponse {
    if let Some(source) = request.additional_sources.first() {
        let result = failed(format!("source `{source}`: only shipped scenes are listed"));
        return WorldsResponse { result, worlds: Vec::new() };
    }
    // Shipped scenes have no tags.
    let wanted = |_: &&str| entities::has_tags(&[], &request.filter);
    let worlds = shipped::names().filter(wanted).map(|name| world(name, name)).collect();
    WorldsResponse { result: done(), worlds }
}
