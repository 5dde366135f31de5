//! The wire of a node: ports on which teams and referees command the game, and what they are told.
//!
//! A batch of datagrams is one input of the loop, like a message; frames of vision are due at their
//! own rate, on simulated time: while that stands still nothing is told. What a datagram means is
//! known to [`crate::wire`]; here are sockets, time stamps and the way to the stage.

mod perform;
mod sockets;
#[cfg(test)]
mod tests;

use std::collections::{BTreeSet, VecDeque};
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use futures::stream::LocalBoxStream;
use tokio::net::UdpSocket;

use super::complaints::Complaints;
use super::stage::Stage;
use crate::wire::control::{self, Control};
use crate::wire::field::{Field, League};
use crate::wire::orders::{Asked, Orders};
use crate::wire::proto::vision::{SslBallModelStraightTwoPhase, SslGeometryData};
use crate::wire::realism::{Noise, Realism};
use crate::wire::vision::{self, Cameras, Stamp};
use crate::wire::{
    Code, Faults, RobotName, Team, View, geometry, grsim, limits, robots, tracked, vsss,
};
use perform::Book;
pub(super) use perform::view;
pub use sockets::{Batch, Way};
use sockets::{Purpose, batches, listen, sender};

/// How the wire is to be laid.
#[derive(Clone, Debug)]
pub struct WireOptions {
    /// Field and protocol.
    pub field: Field,
    /// Where to listen.
    pub listen: Ipv4Addr,
    /// SSL: control, blue, yellow, and grSim's older packets if there is a fourth. VSSS: one.
    pub ports: Vec<u16>,
    /// Where the status of blue and yellow robots goes after grSim's older packets, at whoever
    /// sent them.
    pub status_ports: [u16; 2],
    /// Where vision goes, or the environment of VSSS.
    pub vision: SocketAddrV4,
    /// SSL: where tracked frames go.
    pub tracked: SocketAddrV4,
    /// How datagrams leave.
    pub way: Way,
    /// Frames in a simulated second.
    pub rate_hz: f64,
    /// 1, 2, 4 or 8.
    pub cameras: u32,
    /// How badly they see at first.
    pub realism: Realism,
    /// Seed of noise.
    pub seed: u64,
}

impl WireOptions {
    /// As the league has it, on this machine alone.
    pub fn new(field: Field) -> Self {
        let (ports, group, port) = match field.league {
            League::Ssl => {
                (vec![10_300, 10_301, 10_302, 20_011], Ipv4Addr::new(224, 5, 23, 2), 10_020)
            }
            League::Vsss => (vec![20_011], Ipv4Addr::new(224, 0, 0, 1), 10_002),
        };
        Self {
            field,
            listen: Ipv4Addr::LOCALHOST,
            ports,
            status_ports: [30_011, 30_012],
            vision: SocketAddrV4::new(group, port),
            tracked: SocketAddrV4::new(group, 10_010),
            way: Way { interface: None, reach: 0 },
            rate_hz: 60.0,
            cameras: 1,
            realism: Realism::default(),
            seed: 0,
        }
    }
}

/// Geometry is told so often, s of simulated time.
const GEOMETRY_PERIOD_S: f64 = 1.0;

/// All sockets, before there is a loop.
pub struct Ports {
    options: WireOptions,
    listening: Vec<(Purpose, std::net::UdpSocket)>,
    out: std::net::UdpSocket,
}

impl Ports {
    /// Opens all of them.
    ///
    /// # Errors
    /// One line: which port, and why not.
    pub fn open(options: &WireOptions) -> Result<Self, String> {
        let purposes: &[Purpose] = match options.field.league {
            League::Ssl => &[
                Purpose::Control,
                Purpose::Robots(Team::Blue),
                Purpose::Robots(Team::Yellow),
                Purpose::GrSim,
            ],
            League::Vsss => &[Purpose::Vsss],
        };
        let mut listening = Vec::new();
        for (purpose, port) in purposes.iter().zip(&options.ports) {
            let socket = listen(SocketAddrV4::new(options.listen, *port), *purpose)?;
            tracing::info!("wire: {} on {}:{port}", purpose.name(), options.listen);
            listening.push((*purpose, socket));
        }
        let out = sender(&options.way)?;
        tracing::info!("wire: vision to {}, {} Hz", options.vision, options.rate_hz);
        Ok(Self { options: options.clone(), listening, out })
    }
}

/// The wire of a running node.
pub struct Wire {
    options: WireOptions,
    /// Whether the scene has a field that can be told.
    has_field: bool,
    cameras: Cameras,
    book: Book,
    /// The status that teams know.
    told: grsim::Told,
    noise: Noise,
    out: UdpSocket,
    /// Of the next frame, s of simulated time times the rate.
    next: u64,
    /// Frames so far, since the start.
    frames: u32,
    /// s of simulated time.
    next_geometry: f64,
    /// Unix time of simulated time 0, s; known from the first frame on.
    epoch: Option<f64>,
    /// Simulated time of the last frame, s.
    last: f64,
    /// Frames that are delayed: when they are due (s of simulated time), where to, and what.
    waiting: VecDeque<(f64, SocketAddrV4, Vec<u8>)>,
    uuid: String,
}

/// What a batch asks of whoever runs the loop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wanted {
    /// Pucks have come or gone.
    pub pucks: bool,
    /// Simulated seconds in a second; 0 = a pause.
    pub speed: Option<f64>,
}

impl Wire {
    /// Ready to run, with all that arrives.
    ///
    /// # Errors
    /// What the system says.
    pub fn new(ports: Ports) -> std::io::Result<(Self, Vec<LocalBoxStream<'static, Batch>>)> {
        let Ports { options, listening, out } = ports;
        let streams = listening.into_iter().map(|(purpose, socket)| batches(socket, purpose));
        let streams = streams.collect::<Result<Vec<_>, _>>()?;
        let wire = Self {
            has_field: true,
            cameras: Cameras::new(options.cameras, &options.field),
            book: Book::new(options.field),
            told: grsim::Told::default(),
            noise: Noise::new(options.seed),
            out: UdpSocket::from_std(out)?,
            next: 0,
            frames: 0,
            next_geometry: 0.0,
            epoch: None,
            last: 0.0,
            waiting: VecDeque::new(),
            uuid: uuid(unix_time().as_nanos() ^ u128::from(std::process::id()) << 64),
            options,
        };
        Ok((wire, streams))
    }

    /// Simulated time of the next frame, s.
    pub fn next_frame(&self) -> f64 {
        self.next as f64 / self.options.rate_hz
    }

    /// Simulated time at which something is to be sent, s.
    pub fn due(&self) -> f64 {
        let waiting = self.waiting.front().map_or(f64::INFINITY, |(due, _, _)| *due);
        self.next_frame().min(waiting)
    }

    /// Does what a batch asks, now, and answers it.
    pub fn receive(
        &mut self,
        batch: &Batch,
        stage: &mut Stage,
        complaints: &mut Complaints,
    ) -> Wanted {
        match batch.purpose {
            Purpose::Robots(team) => self.robots(team, batch, stage, complaints),
            Purpose::Control => self.control(batch, stage, complaints),
            Purpose::GrSim | Purpose::Vsss => self.packets(batch, stage, complaints),
        }
    }

    /// Of all orders of a batch to a robot the latest counts.
    fn robots(
        &mut self,
        team: Team,
        batch: &Batch,
        stage: &mut Stage,
        complaints: &mut Complaints,
    ) -> Wanted {
        let mut all = Orders::default();
        let mut told = Vec::new();
        for (from, datagram) in &batch.datagrams {
            let is_there = |name: RobotName| perform::robot(stage, name).is_some();
            let (orders, faults) = match too_long(datagram) {
                Some(faults) => (Orders::default(), faults),
                None => robots::read(team, datagram, is_there),
            };
            all.extend(&orders);
            told.push((from, orders, faults));
        }
        let mut failed = Faults::default();
        self.book.order(stage, &all, &mut failed);
        complain(complaints, batch, &failed);
        for (from, orders, mut faults) in told {
            complain(complaints, batch, &faults);
            failed.iter().for_each(|fault| faults.push(fault.clone()));
            let feedback = orders.iter().map(|(name, _)| (name, self.book.has_ball(stage, name)));
            reply(batch, *from, &robots::answer(&faults, feedback));
        }
        Wanted::default()
    }

    fn control(&mut self, batch: &Batch, stage: &mut Stage, complaints: &mut Complaints) -> Wanted {
        let mut wanted = Wanted::default();
        for (from, datagram) in &batch.datagrams {
            let (control, mut faults) = match too_long(datagram) {
                Some(faults) => (Control::default(), faults),
                None => control::read(datagram),
            };
            self.book.change(stage, &control.specs, &mut faults);
            if control.geometry.is_some() && !self.has_field {
                faults.add(Code::Unsupported, "config.geometry: this scene has no field");
            } else if let Some(asked) = &control.geometry {
                let told = self.geometry(&self.book.view(stage), stage);
                geometry::differences(asked, &told).into_iter().for_each(|it| faults.push(it));
            }
            let Control { robots, ball, .. } = &control;
            wanted.pucks |= self.book.place(stage, robots, ball.as_ref(), &mut faults);
            wanted.speed = control.speed.or(wanted.speed);
            if let Some(change) = control.realism {
                self.options.realism = self.options.realism.with(change);
            }
            control.vision_port.iter().for_each(|port| self.options.vision.set_port(*port));
            complain(complaints, batch, &faults);
            reply(batch, *from, &control::answer(&faults));
        }
        wanted
    }

    /// Of packets in which all may stand; who commands a team of grSim's is told what has changed.
    fn packets(&mut self, batch: &Batch, stage: &mut Stage, complaints: &mut Complaints) -> Wanted {
        let mut wanted = Wanted::default();
        let mut all = Orders::default();
        let mut senders = BTreeSet::new();
        for (from, datagram) in &batch.datagrams {
            let radius = |name: RobotName| perform::robot(stage, name).map(|puck| puck.disc.radius);
            let (asked, mut faults) = match (too_long(datagram), batch.purpose) {
                (Some(faults), _) => (Asked::default(), faults),
                (None, Purpose::GrSim) => grsim::read(datagram, |name| radius(name).is_some()),
                (None, _) => vsss::read(datagram, radius),
            };
            all.extend(&asked.orders);
            senders.extend(asked.team.map(|team| (team, from.ip())));
            let (robots, ball) = (&asked.robots, asked.ball.as_ref());
            wanted.pucks |= self.book.place(stage, robots, ball, &mut faults);
            complain(complaints, batch, &faults);
        }
        let mut faults = Faults::default();
        self.book.order(stage, &all, &mut faults);
        complain(complaints, batch, &faults);
        let teams: BTreeSet<_> = senders.iter().map(|(team, _)| *team).collect();
        for team in teams {
            let Some(news) = self.told.news(self.book.status(stage, team).into_iter()) else {
                continue;
            };
            let port = self.options.status_ports[team as usize];
            for (_, sender) in senders.iter().filter(|(of, _)| *of == team) {
                reply(batch, SocketAddr::new(*sender, port), &news);
            }
        }
        wanted
    }

    /// Takes a frame, if it is time for one, and sends what is due.
    pub fn look(&mut self, stage: &Stage, complaints: &mut Complaints) {
        let Some(now) = stage.world().arena().map(|arena| arena.now()) else { return };
        if now >= self.next_frame() {
            self.last = now;
            if self.has_field {
                let view = self.book.view(stage);
                self.frame(&view, stage);
            }
            self.next = (now * self.options.rate_hz).floor() as u64 + 1;
            // The product may be a rounding below the frame that it was.
            if self.next_frame() <= now {
                self.next += 1;
            }
        }
        while self.waiting.front().is_some_and(|(due, _, _)| *due <= now) {
            let Some((_, to, datagram)) = self.waiting.pop_front() else { break };
            if let Err(error) = self.out.try_send_to(&datagram, to.into()) {
                complaints.unsent("wire", &format_args!("to {to}: {error}"));
            }
        }
    }

    fn frame(&mut self, view: &View, stage: &Stage) {
        let WireOptions { field, vision, tracked, realism, .. } = self.options;
        let began = || unix_time().as_secs_f64() - view.time;
        let capture = *self.epoch.get_or_insert_with(began) + view.time;
        let due = view.time + realism.delay_s;
        let number = self.frames;
        self.frames = self.frames.wrapping_add(1);
        if field.league == League::Vsss {
            return self.waiting.push_back((due, vision, vsss::environment(view, number, &field)));
        }
        let stamp = Stamp { number, capture, sent: capture + realism.delay_s };
        for frame in self.cameras.look(view, stamp, &realism, &mut self.noise) {
            self.waiting.push_back((due, vision, vision::detection(frame)));
        }
        let frame = tracked::frame(view, number, capture);
        self.waiting.push_back((due, tracked, tracked::packet(&self.uuid, frame)));
        if view.time >= self.next_geometry {
            self.next_geometry = view.time + GEOMETRY_PERIOD_S;
            let data = self.geometry(view, stage);
            self.waiting.push_back((due, vision, vision::geometry(data)));
        }
    }

    fn geometry(&self, view: &View, stage: &Stage) -> SslGeometryData {
        geometry::data(&self.options.field, &self.cameras, things(view, stage), ball(stage))
    }

    /// Follows what was done to the stage: its time may have begun anew. Of a new world, which may
    /// be of another scene, nothing is known but the scene.
    pub fn follow(&mut self, stage: &Stage, is_new: bool, complaints: &mut Complaints) {
        let now = stage.world().arena().map_or(0.0, |arena| arena.now());
        if now < self.last {
            self.restart();
        }
        if !is_new {
            return;
        }
        self.has_field = stage.scene().field.is_some();
        match stage.scene().field {
            Some(marks) => self.options.field = Field::new(self.options.field.league, marks),
            None => complaints.say("wire", &"the scene has no `field`: teams see nothing of it"),
        }
        self.cameras = Cameras::new(self.options.cameras, &self.options.field);
        self.book = Book::new(self.options.field);
        self.next_geometry = 0.0;
    }

    /// Simulated time has begun anew: time stamps go on all the same.
    fn restart(&mut self) {
        self.epoch = self.epoch.map(|epoch| epoch + self.last);
        (self.last, self.next_geometry, self.next) = (0.0, 0.0, 0);
        self.waiting.clear();
    }
}

/// What the things on the field measure.
fn things(view: &View, stage: &Stage) -> geometry::Things {
    let robot_radius = view.robots.iter().map(|robot| robot.radius).fold(0.0, f64::max);
    let ball_radius = perform::ball(stage).map_or(0.0, |puck| puck.disc.radius);
    geometry::Things { ball_radius, robot_radius }
}

/// How the ball slows down, as geometry has it.
fn ball(stage: &Stage) -> Option<SslBallModelStraightTwoPhase> {
    let ball = perform::ball(stage)?.ball?;
    Some(SslBallModelStraightTwoPhase {
        acc_slide: -ball.sliding,
        acc_roll: -ball.rolling,
        k_switch: ball.switch_ratio,
    })
}

fn unix_time() -> Duration {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default()
}

fn too_long(datagram: &[u8]) -> Option<Faults> {
    let most = limits::DATAGRAM_BYTES;
    (datagram.len() > most).then(|| {
        let mut faults = Faults::default();
        faults.add(Code::OutOfRange, format!("a datagram of more than {most} bytes"));
        faults
    })
}

/// Faults are counted and logged, but for those that only say what carom has not.
fn complain(complaints: &mut Complaints, batch: &Batch, faults: &Faults) {
    for fault in faults.iter() {
        if let Some(cause) = fault.code.cause() {
            complaints.refuse(batch.purpose.name(), cause, fault);
        }
    }
}

/// Who does not take an answer now does without.
fn reply(batch: &Batch, to: SocketAddr, datagram: &[u8]) {
    let _ = batch.socket.try_send_to(datagram, to);
}

/// A number as an id of version 4.
fn uuid(number: u128) -> String {
    let number = number.wrapping_mul(0x9e37_79b9_7f4a_7c15_f39c_c060_5ced_c835);
    let [a, b, c, d, e] = [96, 80, 64, 48, 0].map(|shift| (number >> shift) as u64);
    let (b, c, d) = (b & 0xffff, c & 0xfff, d & 0xfff);
    format!("{a:08x}-{b:04x}-4{c:03x}-8{d:03x}-{:012x}", e & 0xffff_ffff_ffff)
}
