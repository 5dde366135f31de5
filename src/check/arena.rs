//! Scenes of the cases and their run, through the world that the node steps.

use glam::DVec2;

use super::case::{Field, Malformed, Read};
use crate::motion::arena::Halt;
use crate::motion::plain::Stall;
use crate::world::{Contact, Disc, Instants, Partner, Settings, Side, Walls, World, limits};

/// Why a case gave no verdict.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Trouble {
    /// The file.
    #[error(transparent)]
    Malformed(#[from] Malformed),
    /// The arena.
    #[error(transparent)]
    Halt(#[from] Halt),
    /// The same of a method by itself.
    #[error(transparent)]
    Stall(#[from] Stall),
}

/// A scene as a case gives it.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Restitution, walls, gravity.
    pub settings: Settings,
    /// The discs; their ids are their indices.
    pub discs: Vec<Disc>,
}

impl Setup {
    /// Reads `bodies`, `box`, `e`, `e_wall` and `g`.
    pub fn read(inputs: &Field) -> Read<Self> {
        Ok(Self::read_laws(inputs)?.with(discs(&inputs.get("bodies")?)?))
    }

    /// The same without bodies, for cases whose sub-cases have them.
    pub fn read_laws(inputs: &Field) -> Read<Self> {
        let restitution = fraction(inputs, "e")?;
        let mut settings = Settings { restitution, ..Settings::default() };
        if inputs.find("box").is_some() {
            settings.walls = Some(walls(inputs, fraction(inputs, "e_wall")?)?);
        }
        if let Some(gravity) = inputs.find("g") {
            settings.gravity = Some(DVec2::NEG_Y * gravity.finite()?);
        }
        Ok(Self { settings, discs: Vec::new() })
    }

    /// The same scene with other discs.
    pub fn with(&self, discs: Vec<Disc>) -> Self {
        Self { settings: self.settings, discs }
    }
}

/// A restitution; 1 where the case gives none.
fn fraction(inputs: &Field, key: &str) -> Read<f64> {
    let Some(field) = inputs.find(key) else { return Ok(1.0) };
    let value = field.number()?;
    if (0.0..=1.0).contains(&value) { Ok(value) } else { Err(field.wrong("must be from 0 to 1")) }
}

/// The walls of `box`.
pub fn walls(inputs: &Field, restitution: f64) -> Read<Walls> {
    let field = inputs.get("box")?;
    let side = |k: usize| field.item(k)?.finite();
    let (min, max) = (DVec2::new(side(0)?, side(1)?), DVec2::new(side(2)?, side(3)?));
    if min.x < max.x && min.y < max.y {
        return Ok(Walls { min, max, restitution });
    }
    Err(field.wrong("must be [xmin, ymin, xmax, ymax]"))
}

/// The discs of a list of bodies, at least one, refused where the world would refuse them.
pub fn discs(bodies: &Field) -> Read<Vec<Disc>> {
    let list = bodies.items()?;
    if list.is_empty() || list.len() > limits::PUCKS_PER_SCENE {
        return Err(bodies.wrong("must be at least one body"));
    }
    list.iter().enumerate().map(|(k, body)| disc(body, k as u32)).collect()
}

/// One body as a sound disc.
pub fn disc(body: &Field, id: u32) -> Read<Disc> {
    let disc = any_disc(body, id)?;
    disc.defect().map_or(Ok(disc), |defect| Err(body.wrong(defect)))
}

/// One body, whatever its numbers.
pub fn any_disc(body: &Field, id: u32) -> Read<Disc> {
    let number = |key: &str| body.get(key)?.number();
    Ok(Disc {
        id,
        position: DVec2::new(number("x")?, number("y")?),
        velocity: DVec2::new(number("vx")?, number("vy")?),
        radius: number("r")?,
        mass: number("m")?,
    })
}

/// A scene on its way.
#[derive(Clone, Debug)]
pub struct Run {
    world: World,
    /// Contacts of pairs so far.
    pub pairs: u64,
    /// Contacts with walls so far.
    pub walls: u64,
}

impl Run {
    /// At time 0.
    pub fn new(setup: &Setup) -> Self {
        Self { world: World::new(setup.settings, &setup.discs), pairs: 0, walls: 0 }
    }

    /// Advances to `until` (s) and shows every contact on the way.
    pub fn advance(&mut self, until: f64, mut see: impl FnMut(&Contact)) -> Result<(), Halt> {
        while self.now() < until {
            let outcome = self.world.step(&[], Instants { heard_at: 0.0, advance_to: until });
            for contact in &outcome.contacts {
                match contact.b {
                    Partner::Disc(_) => self.pairs += 1,
                    Partner::Wall(_) | Partner::Segment(_) => self.walls += 1,
                }
                see(contact);
            }
            if let Some(stall) = outcome.stall {
                return Err(stall);
            }
        }
        Ok(())
    }

    /// Advances and keeps the contacts.
    pub fn contacts(&mut self, until: f64) -> Result<Vec<Contact>, Halt> {
        let mut contacts = Vec::new();
        self.advance(until, |contact| contacts.push(*contact))?;
        Ok(contacts)
    }

    /// Advances without looking.
    pub fn pass(&mut self, until: f64) -> Result<(), Halt> {
        self.advance(until, |_| ())
    }

    /// The present, s.
    pub fn now(&self) -> f64 {
        self.world.arena().map_or(f64::INFINITY, |arena| arena.now())
    }

    /// The discs now, by id.
    pub fn discs(&self) -> Vec<Disc> {
        let arena = self.world.arena();
        arena.into_iter().flat_map(|arena| arena.discs(crate::world::Owner::Simulated)).collect()
    }

    /// Largest overlap at any contact, in units of the smaller radius.
    pub fn largest_overlap(&self) -> f64 {
        self.world.arena().map_or(0.0, |arena| arena.largest_overlap())
    }
}

/// The letter of a wall in the files.
pub fn letter(side: Side) -> &'static str {
    match side {
        Side::Left => "L",
        Side::Right => "R",
        Side::Bottom => "B",
        Side::Top => "T",
    }
}
