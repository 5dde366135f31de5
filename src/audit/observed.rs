//! Contacts of audited discs with circles that others report, as the bag has them.
//!
//! Such a circle is in no sample of the discs, and between its reports only the simulator knows
//! where it took it to be: its contacts say when it met whom. A contact counts only if the partner
//! was reported in the same bag. Never judge anything here.

use std::collections::HashSet;

use super::recorded::{CIRCLES, Chosen};
use super::surroundings::Meeting;
use crate::bag::decode;
use crate::bag::read::{Bag, Topic};
use crate::messages::{CircleStates, Contact, Contacts};
use crate::world::DiscId;

/// The type of contacts.
const CONTACTS: &str = "carom/msg/Contacts";

/// When, in order, discs met circles that are reported elsewhere in the bag; and what is to be said
/// where that is not recorded.
pub(super) fn meetings(bag: &Bag, chosen: &Chosen) -> (Vec<Meeting>, Option<String>) {
    // Robots have other ids here, and times of recording are none of contacts.
    if !chosen.is_of_circles_with_stamps() {
        return (Vec::new(), None);
    }
    let reported = reported(bag, chosen);
    if reported.is_empty() {
        return (Vec::new(), None);
    }
    if !bag.topics().iter().any(|topic| topic.kind == CONTACTS) {
        let what = "others report circles, but no contacts are recorded: what pucks did at them \
                    may be called a violation";
        return (Vec::new(), Some(what.to_owned()));
    }
    let messages = bag.messages(|topic| topic.kind == CONTACTS).flatten();
    let lists = messages.filter_map(|message| decode::message::<Contacts>(&message.payload).ok());
    let is_with_one = |contact: &Contact| {
        let Contact { a, b, .. } = contact;
        *b != Contact::WALL && (reported.contains(a) || reported.contains(b))
    };
    let meeting = |contact: Contact| Meeting { time: contact.time, discs: [contact.a, contact.b] };
    let all = lists.flat_map(|list| list.contacts).filter(is_with_one);
    let mut meetings: Vec<Meeting> = all.map(meeting).collect();
    meetings.sort_by(|a, b| a.time.total_cmp(&b.time));
    (meetings, None)
}

/// The ids of all circles that are reported on topics that are not audited.
fn reported(bag: &Bag, chosen: &Chosen) -> HashSet<DiscId> {
    let is_other = |topic: &Topic| topic.kind == CIRCLES && !chosen.has(bag, topic);
    let messages = bag.messages(is_other).flatten();
    let states = messages.filter_map(|each| decode::message::<CircleStates>(&each.payload).ok());
    states.flat_map(|states| states.circles).map(|circle| circle.id).collect()
}
