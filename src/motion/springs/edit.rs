//! What is asked from outside: other velocities, discs that come, move and go, other walls.
//!
//! A step ends where somebody asks, and steps are counted from there. What an edit does to the
//! energy of motion and of the springs is booked as work.

use glam::DVec2;

use super::links::{Link, Other};
use super::{Refused, Springs};
use crate::motion::entry::{is_clear, may_stand, moved};
use crate::world::{Disc, DiscId, NotDone};

impl Springs {
    /// Gives a disc, if it is there, a new velocity from now on; steps are counted from here.
    ///
    /// # Errors
    /// [`Refused`] if the arena cannot get to the present; nothing is changed then.
    pub fn set_velocity(&mut self, id: DiscId, velocity: DVec2) -> Result<(), Refused> {
        let Some(k) = self.discs.iter().position(|disc| disc.id == id) else { return Ok(()) };
        if self.now_discs()[k].velocity == velocity {
            return Ok(());
        }
        self.end_step()?;
        let before = self.discs[k].kinetic_energy();
        self.discs[k].velocity = velocity;
        self.energy.book(self.discs[k].kinetic_energy() - before);
        Ok(())
    }

    /// Adds a disc, which begins without a contact.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn add(&mut self, disc: Disc) -> Result<(), NotDone> {
        may_stand(&disc, self.laws.walls.as_ref())?;
        if self.discs.iter().any(|other| other.id == disc.id) {
            return Err(NotDone::Taken(disc.id));
        }
        is_clear(&disc, self.now_discs().iter().copied(), None)?;
        self.edit(|arena| arena.discs.push(disc))
    }

    /// Takes a disc out; its contacts end.
    ///
    /// # Errors
    /// [`NotDone`] if there is none.
    pub fn remove(&mut self, id: DiscId) -> Result<(), NotDone> {
        let k = self.place_of(id)?;
        self.edit(|arena| {
            arena.end_contacts(k);
            arena.discs.remove(k);
            let after = |place: usize| place - usize::from(place > k);
            let renumbered = std::mem::take(&mut arena.open).into_iter().map(|(link, contact)| {
                let b = match link.b {
                    Other::Disc(b) => Other::Disc(after(b)),
                    wall @ Other::Wall(_) => wall,
                };
                (Link { a: after(link.a), b }, contact)
            });
            arena.open = renumbered.collect();
        })
    }

    /// Puts a disc somewhere else, with another velocity; its contacts end.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn place(&mut self, id: DiscId, position: DVec2, velocity: DVec2) -> Result<(), NotDone> {
        let k = self.place_of(id)?;
        let after = Disc { position, velocity, ..self.discs[k] };
        may_stand(&after, self.laws.walls.as_ref())?;
        let others = self.now_discs().iter().filter(|other| other.id != id).copied();
        is_clear(&after, others, None)?;
        self.edit(|arena| {
            arena.end_contacts(k);
            arena.discs[k] = after;
        })
    }

    /// Moves the walls, and brings discs inside; contacts with walls, and of discs that moved, end.
    ///
    /// # Errors
    /// [`NotDone`] if there are no walls, or no room within; nothing is changed then.
    pub fn move_walls(&mut self, min: DVec2, max: DVec2) -> Result<(), NotDone> {
        let widest = self.discs.iter().map(|disc| disc.radius).fold(0.0, f64::max);
        let walls = moved(self.laws.walls, (min, max), widest)?;
        self.edit(|arena| {
            for k in 0..arena.discs.len() {
                let position = walls.inside(&arena.discs[k]);
                if position != arena.discs[k].position {
                    arena.end_contacts(k);
                    arena.discs[k].position = position;
                }
            }
            arena.end(|link| matches!(link.b, Other::Wall(_)));
            arena.laws.walls = Some(walls);
        })
    }

    fn place_of(&self, id: DiscId) -> Result<usize, NotDone> {
        self.discs.iter().position(|disc| disc.id == id).ok_or(NotDone::Unknown(id))
    }

    /// Changes discs at the present, and books what that does to the energy.
    fn edit(&mut self, change: impl FnOnce(&mut Self)) -> Result<(), NotDone> {
        self.end_step().map_err(|_| NotDone::Halted)?;
        let before = self.mechanical_energy();
        change(self);
        self.energy.book(self.mechanical_energy() - before);
        self.neighbours = super::Neighbours::default();
        Ok(())
    }

    /// Ends the step at the present.
    fn end_step(&mut self) -> Result<(), Refused> {
        if self.now > self.time() {
            let works = self.moved(self.now - self.time())?;
            self.take(&works);
            (self.base, self.count) = (self.now, 0);
            let mut ended = std::mem::take(&mut self.ended);
            self.close(&mut ended);
            self.ended = ended;
        }
        Ok(())
    }

    /// Ends the contacts of a disc; what their springs hold goes with it.
    fn end_contacts(&mut self, k: usize) {
        self.end(|link| link.a == k || link.b == Other::Disc(k));
    }

    fn end(&mut self, ends: impl Fn(&Link) -> bool) {
        let ended = &mut self.ended;
        self.open.retain(|link, contact| {
            if ends(link) {
                ended.push(*contact);
            }
            !ends(link)
        });
    }
}
