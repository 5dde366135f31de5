//! The participant's last word: one RTPS packet that Fast DDS understands.
//!
//! RustDDS 0.15.1 disposes of its participant with a serialized key; Fast DDS drops keys of more
//! than 16 bytes and wants PID_KEY_HASH (RTPS 2.5, 9.6.4.8), so that a closed node's endpoints
//! stay in the graph for the lease of 50 s. This packet carries the key hash.
//! It must never fail the caller: nobody may be listening, and the lease ends the matter anyway.

use std::net::{Ipv4Addr, UdpSocket};

/// Ports after RTPS 2.5, 9.6.2.3: base, per domain, offset and step of the unicast ports.
const PORT_BASE: u16 = 7400;
const PORTS_PER_DOMAIN: u16 = 250;
const UNICAST_OFFSET: u16 = 10;
const UNICAST_STEP: u16 = 2;
const USER_OFFSET: u16 = 11;

/// Participants on this host that are told one by one, as RustDDS does in discovery.
pub const PARTICIPANTS_TOLD: u16 = 12;

/// Later than any announcement the participant can have sent.
const SEQUENCE_NUMBER: u32 = 1 << 30;

/// The port at which a participant hears what is not discovery, if there is one.
pub fn user_port(domain_id: u16, participant_id: u16) -> Option<u16> {
    unicast_port(domain_id, USER_OFFSET, participant_id)
}

fn unicast_port(domain_id: u16, offset: u16, participant_id: u16) -> Option<u16> {
    let own = offset.checked_add(UNICAST_STEP.checked_mul(participant_id)?)?;
    PORTS_PER_DOMAIN.checked_mul(domain_id)?.checked_add(PORT_BASE)?.checked_add(own)
}

/// Tells the domain that the participant with this GUID is gone. Send it after its threads ended.
pub fn send(participant_guid: [u8; 16], domain_id: u16, multicast: bool) {
    let packet = packet(participant_guid);
    let Ok(socket) = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)) else { return };
    let base = PORT_BASE + PORTS_PER_DOMAIN * domain_id;
    let unicast = (0..PARTICIPANTS_TOLD)
        .filter_map(|index| unicast_port(domain_id, UNICAST_OFFSET, index))
        .map(|port| (Ipv4Addr::LOCALHOST, port));
    let group = multicast.then_some((Ipv4Addr::new(239, 255, 0, 1), base));
    for address in unicast.chain(group) {
        // Nobody at that port is no failure.
        let _ = socket.send_to(&packet, address);
    }
}

/// Header, one DATA submessage without payload, inline QoS with key hash and status.
fn packet(guid: [u8; 16]) -> Vec<u8> {
    let mut data = Vec::with_capacity(96);
    data.extend(b"RTPS\x02\x04\x01\x12");
    data.extend(&guid[..12]);
    data.extend([0x15, 0x03]); // DATA; little-endian, with inline QoS
    data.extend(52_u16.to_le_bytes()); // octets that follow
    data.extend([0, 0, 16, 0]); // no extra flags; 16 octets to the inline QoS
    data.extend([0x00, 0x01, 0x00, 0xc7]); // SPDP reader
    data.extend([0x00, 0x01, 0x00, 0xc2]); // SPDP writer
    data.extend(0_u32.to_le_bytes());
    data.extend(SEQUENCE_NUMBER.to_le_bytes());
    data.extend([0x70, 0, 16, 0]); // PID_KEY_HASH
    data.extend(guid);
    data.extend([0x71, 0, 4, 0, 0, 0, 0, 3]); // PID_STATUS_INFO: disposed, unregistered
    data.extend([1, 0, 0, 0]); // PID_SENTINEL
    data
}

#[cfg(test)]
mod tests {
    #[test]
    fn length_field_matches() {
        let packet = super::packet([7; 16]);
        assert_eq!(packet.len() - 24, usize::from(u16::from_le_bytes([packet[22], packet[23]])));
    }
}
