//! Is a disc caught in a collapse: endlessly many contacts in a finite time?
//!
//! Below restitution 1 it is, once so many contacts in a row each followed the one before within
//! the contact time; contacts among caught discs are elastic until they have peace.
//!
//! A disc that meets the same one or two partners over and over is free of the rest of the arena.
//! Such a collapse ends by itself, at an instant that can be computed, so it is followed farther,
//! and its contacts are remembered. In a cage of many discs that would only make the hops after it
//! shorter, and more.

use crate::world::limits;

/// What a body knows of its contacts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Collapse {
    /// Offset of the last contact, s.
    last_contact: f64,
    /// Contacts in a row, each within the contact time of the one before.
    quick_contacts: u32,
    /// The last two partners, the later one first.
    partners: [Option<usize>; 2],
    /// Contacts in a row with none but these.
    with_partners: u32,
}

impl Default for Collapse {
    fn default() -> Self {
        Self {
            last_contact: f64::NEG_INFINITY,
            quick_contacts: 0,
            partners: [None; 2],
            with_partners: 0,
        }
    }
}

impl Collapse {
    /// Offset of the last contact, s; negative infinity before the first.
    pub fn last_contact(&self) -> f64 {
        self.last_contact
    }

    /// Takes note of a contact with one partner, or with walls or several at once. `contact_time`
    /// (s) is that after the last contact.
    pub fn note_contact(&mut self, offset: f64, partner: Option<usize>, contact_time: f64) {
        let quick = offset - self.last_contact < contact_time;
        self.quick_contacts = if quick { self.quick_contacts.saturating_add(1) } else { 0 };
        self.last_contact = offset;
        if partner.is_none() {
            self.forget_partners();
        } else if self.partners.contains(&partner) {
            self.with_partners = self.with_partners.saturating_add(1);
        } else {
            (self.partners, self.with_partners) = ([partner, self.partners[0]], 0);
        }
    }

    /// Whether it is caught, seen at an offset.
    pub fn is_caught(&self, offset: f64, contact_time: f64) -> bool {
        let free = self.with_partners >= self.quick_contacts;
        let most = if free { limits::QUICK_CONTACTS_IF_FREE } else { limits::QUICK_CONTACTS };
        self.quick_contacts >= most && offset - self.last_contact < contact_time
    }

    /// Whether it has long met none but one or two partners.
    pub fn is_free(&self) -> bool {
        self.with_partners >= limits::CONTACTS_IF_FREE
    }

    /// Forgets who its partners were.
    pub fn forget_partners(&mut self) {
        (self.partners, self.with_partners) = ([None; 2], 0);
    }

    /// Moves the base of all offsets.
    pub fn rebase(&mut self, shift: f64) {
        self.last_contact -= shift;
    }

    /// Tells time anew: an offset becomes another, and all else takes longer by what slows discs.
    pub fn begin_again(&mut self, offset: f64, at: f64, slowed: f64) {
        self.last_contact = at + (self.last_contact - offset) / slowed;
    }
}
