//! `carom run --wire`: what the command line says about ports, cameras and where vision goes.
//!
//! Without `--wire` none of it is allowed, so that nobody waits for packets that never come.

use std::net::{Ipv4Addr, SocketAddrV4};

use carom::node::wire::{Way, WireOptions};
use carom::scene::Scene;
use carom::wire::field::{Field, League};
use carom::wire::realism::Realism;
use carom::wire::{limits, vision};
use clap::Args;

/// Of teams' own software.
#[derive(Args, Default)]
pub struct WireArguments {
    /// Speak to teams' software on their league's own protocol; --wire=ssl or --wire=vsss for a
    /// scene whose name does not begin so.
    #[arg(long, value_name = "LEAGUE", num_args = 0..=1, require_equals = true)]
    #[arg(default_missing_value = "auto", value_parser = ["auto", "ssl", "vsss"])]
    wire: Option<String>,
    /// Listen on this address; 0.0.0.0 = on all networks [default: 127.0.0.1].
    #[arg(long, value_name = "ADDRESS", requires = "wire")]
    wire_listen: Option<Ipv4Addr>,
    /// Ports for control, blue robots, yellow robots and, if they are named, grSim's older packets,
    /// and where the status of blue and yellow robots goes to those who send them [default:
    /// 10300,10301,10302,20011,30011,30012]; for VSSS one port [default: 20011].
    #[arg(long, value_name = "PORTS", requires = "wire", value_delimiter = ',')]
    #[arg(value_parser = clap::value_parser!(u16).range(1..))]
    wire_ports: Vec<u16>,
    /// By which interface groups are reached, by name or address [default: the system's choice].
    #[arg(long, value_name = "INTERFACE", requires = "wire")]
    wire_interface: Option<String>,
    /// How far groups reach: 0 = this machine, 1 = its own network [default: 0].
    #[arg(long, value_name = "HOPS", requires = "wire")]
    #[arg(value_parser = clap::value_parser!(u32).range(0..=255))]
    wire_ttl: Option<u32>,
    /// Where vision goes [default: 224.5.23.2:10020; for VSSS 224.0.0.1:10002].
    #[arg(long, value_name = "ADDRESS:PORT", requires = "wire")]
    vision: Option<SocketAddrV4>,
    /// Where tracked frames go [default: 224.5.23.2:10010].
    #[arg(long, value_name = "ADDRESS:PORT", requires = "wire")]
    tracked: Option<SocketAddrV4>,
    /// Frames of vision in a simulated second [default: 60].
    #[arg(long, value_name = "HZ", requires = "wire", value_parser = rate)]
    vision_rate: Option<f64>,
    /// Cameras that share the field: 1, 2, 4 or 8 [default: 1].
    #[arg(long, value_name = "N", requires = "wire", value_parser = cameras)]
    cameras: Option<u32>,
    /// Deviation of the ball's place (m), of a robot's (m) and of its heading (rad) [default: 0].
    #[arg(long, value_name = "BALL,ROBOT,HEADING", requires = "wire", value_parser = noise)]
    vision_noise: Option<[f64; 3]>,
    /// Send vision so long after its capture, s of simulated time [default: 0].
    #[arg(long, value_name = "SECONDS", requires = "wire", value_parser = delay)]
    vision_delay: Option<f64>,
    /// Seed of the noise [default: 0].
    #[arg(long, value_name = "S", requires = "wire")]
    vision_seed: Option<u64>,
}

impl WireArguments {
    /// How teams are spoken to in a scene, if they are.
    ///
    /// # Errors
    /// What does not fit, in one line.
    pub fn options(&self, name: &str, scene: &Scene) -> Result<Option<WireOptions>, String> {
        let Some(wire) = &self.wire else { return Ok(None) };
        let league = League::of(if wire == "auto" { name } else { wire });
        let league = league.ok_or_else(|| {
            format!("--wire: which league is {name} of? say --wire=ssl or --wire=vsss")
        })?;
        let marks = scene.field.ok_or_else(|| {
            format!("--wire: {name} has no `field`: run ssl-a, ssl-b, vsss-3v3 or vsss-5v5")
        })?;
        let field = Field::new(league, marks);
        let mut options = WireOptions::new(field);
        self.ports(&mut options)?;
        options.listen = self.wire_listen.unwrap_or(options.listen);
        options.vision = self.vision.unwrap_or(options.vision);
        if field.league == League::Vsss && (self.tracked.is_some() || self.cameras.is_some()) {
            return Err("--tracked and --cameras are for SSL: VSSS has neither".to_owned());
        }
        options.tracked = self.tracked.unwrap_or(options.tracked);
        let reach = self.wire_ttl.unwrap_or(0);
        options.way = Way { interface: self.wire_interface.clone(), reach };
        options.rate_hz = self.vision_rate.unwrap_or(options.rate_hz);
        options.cameras = self.cameras.unwrap_or(1);
        options.seed = self.vision_seed.unwrap_or(0);
        let [ball, robot, heading] = self.vision_noise.unwrap_or_default();
        options.realism = Realism {
            ball_deviation_m: ball,
            robot_deviation_m: robot,
            heading_deviation_rad: heading,
            delay_s: self.vision_delay.unwrap_or(0.0),
            ..Realism::default()
        };
        Ok(Some(options))
    }

    fn ports(&self, options: &mut WireOptions) -> Result<(), String> {
        match (options.field.league, self.wire_ports.as_slice()) {
            (_, []) => return Ok(()),
            (League::Ssl, [_, _, _] | [_, _, _, _]) | (League::Vsss, [_]) => {}
            (League::Ssl, [_, _, _, _, blue, yellow]) => options.status_ports = [*blue, *yellow],
            (League::Ssl, _) => {
                let how = "control,blue,yellow[,grsim[,blue status,yellow status]]";
                return Err(format!("--wire-ports: SSL has three, four or six: {how}"));
            }
            (League::Vsss, _) => return Err("--wire-ports: VSSS has one".to_owned()),
        }
        options.ports.clone_from(&self.wire_ports);
        Ok(())
    }
}

fn number(text: &str, most: f64) -> Option<f64> {
    text.trim().parse().ok().filter(|number| (0.0..=most).contains(number))
}

fn rate(text: &str) -> Result<f64, String> {
    let most = limits::VISION_RATE_MAX_HZ;
    number(text, most)
        .filter(|rate| *rate >= 0.1)
        .ok_or_else(|| format!("must be a rate from 0.1 to {most}, in 1/s"))
}

fn delay(text: &str) -> Result<f64, String> {
    let most = limits::DELAY_MAX_S;
    number(text, most).ok_or_else(|| format!("must be a number of seconds from 0 to {most}"))
}

fn cameras(text: &str) -> Result<u32, String> {
    let count = text.parse().ok().filter(|count| vision::CAMERAS.contains(count));
    count.ok_or_else(|| "must be 1, 2, 4 or 8".to_owned())
}

fn noise(text: &str) -> Result<[f64; 3], String> {
    let all: Option<Vec<f64>> = text.split(',').map(|text| number(text, 10.0)).collect();
    let all = all.and_then(|all| all.try_into().ok());
    all.ok_or_else(|| "must be three numbers from 0 to 10 with commas between them".to_owned())
}
