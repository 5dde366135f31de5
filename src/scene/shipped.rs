//! The scenes that come with the program: the files in `config/`, built in.

/// Name, path in the project, text.
const SHIPPED: [(&str, &str, &str); 12] = [
    ("arena", "config/arena.yaml", include_str!("../../config/arena.yaml")),
    ("break_shot", "config/break_shot.yaml", include_str!("../../config/break_shot.yaml")),
    (
        "newtons_cradle",
        "config/newtons_cradle.yaml",
        include_str!("../../config/newtons_cradle.yaml"),
    ),
    ("head_on", "config/head_on.yaml", include_str!("../../config/head_on.yaml")),
    ("thousand", "config/thousand.yaml", include_str!("../../config/thousand.yaml")),
    ("teams", "config/teams.yaml", include_str!("../../config/teams.yaml")),
    ("ssl-a", "config/ssl-a.yaml", include_str!("../../config/ssl-a.yaml")),
    ("ssl-b", "config/ssl-b.yaml", include_str!("../../config/ssl-b.yaml")),
    ("vsss-3v3", "config/vsss-3v3.yaml", include_str!("../../config/vsss-3v3.yaml")),
    ("vsss-5v5", "config/vsss-5v5.yaml", include_str!("../../config/vsss-5v5.yaml")),
    ("league-2d", "config/league-2d.yaml", include_str!("../../config/league-2d.yaml")),
    ("resolver", "config/resolver.yaml", include_str!("../../config/resolver.yaml")),
];

/// The scene that runs when none is named.
pub const DEFAULT: &str = "arena";

/// The names of all shipped scenes.
pub fn names() -> impl Iterator<Item = &'static str> {
    SHIPPED.iter().map(|(name, _, _)| *name)
}

/// File name and text of a shipped scene.
pub fn find(name: &str) -> Option<(&'static str, &'static str)> {
    SHIPPED.iter().find(|(shipped, _, _)| *shipped == name).map(|(_, file, text)| (*file, *text))
}
