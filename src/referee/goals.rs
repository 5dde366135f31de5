//! Goals: a ball that has wholly crossed a goal line between the posts.
//!
//! Balls are seen at control ticks and fly straight between two of them, but for contacts, so the
//! instant is that of the crossing, to what a contact within the tick bends. What is put elsewhere
//! by hand has crossed nothing. A ball in a goal may leave it again: the next goal counts when it
//! has been wholly within the field, or was put elsewhere. Nobody stops the game here.

use glam::DVec2;

use crate::world::{Disc, DiscId};

/// A goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// The team that scored, as in [`Referee::new`](super::Referee::new).
    pub team: u8,
    /// Centre of the ball when it had wholly crossed the line, m.
    pub place: DVec2,
    /// When, s.
    pub time: f64,
    /// Goals of the teams 0 and 1 with this one.
    pub score: [u32; 2],
}

/// Where goals are, and whose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posts {
    /// From the middle to both goal lines, m.
    pub line: f64,
    /// Half of a goal between its posts, m.
    pub half_width: f64,
    /// Who scores in the goal at negative x, 0 or 1; the other one does at positive x.
    pub scorer_at_left: u8,
}

/// Watches the goals of a field, and keeps the score of the teams 0 and 1.
#[derive(Clone, Debug)]
pub(super) struct Goals {
    posts: Posts,
    ball: DiscId,
    /// When and where the ball was last seen, s and m; nothing if it may be anywhere now.
    seen: Option<(f64, DVec2)>,
    /// Whether it has been in the field since the last goal.
    is_in_play: bool,
    pub score: [u32; 2],
}

impl Goals {
    /// Nobody has scored yet.
    pub fn new(posts: Posts, ball: DiscId) -> Self {
        Self { posts, ball, seen: None, is_in_play: false, score: [0, 0] }
    }

    /// A puck was put elsewhere.
    pub fn lose_sight(&mut self, id: DiscId) {
        if id == self.ball {
            self.seen = None;
        }
    }

    /// Looks where the ball is now.
    pub fn look(&mut self, discs: &[Disc], now: f64) -> Option<Goal> {
        let ball = discs.iter().find(|disc| disc.id == self.ball)?;
        let (line, far) = (self.posts.line, ball.position.x.abs());
        let crossed = line + ball.radius;
        let Some((since, from)) = self.seen.replace((now, ball.position)) else {
            self.is_in_play = far <= crossed;
            return None;
        };
        self.is_in_play |= far < line - ball.radius;
        let side = ball.position.x.signum();
        let (before, after) = (side * from.x, side * ball.position.x);
        if !self.is_in_play || before > crossed || after <= crossed {
            return None;
        }
        let part = (crossed - before) / (after - before);
        let place = from + (ball.position - from) * part;
        if place.y.abs() >= self.posts.half_width {
            return None;
        }
        self.is_in_play = false;
        let is_left = side < 0.0;
        let team = if is_left { self.posts.scorer_at_left } else { 1 - self.posts.scorer_at_left };
        self.score[usize::from(team)] += 1;
        let time = since + (now - since) * part;
        Some(Goal { team, place, time, score: self.score })
    }
}
