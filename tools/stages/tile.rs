//! What the provenance of a tile says: which picture it belongs to, and which part of it it is.
//!
//! {"region":[x,y,w,h],"tile_of":[x,y,w,h],"whole":SETTINGS}
//! `SETTINGS` are those of the picture, letter by letter, so that the picture's own provenance comes
//! back from any of its tiles. A tile that is the whole picture has the picture's settings.

use niji_exchange::Provenance;
use niji_geometry::PixelRegion;

use crate::frame_list::FrameList;

/// A part of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tile {
    /// Its pixels.
    pub region: PixelRegion,
    /// All pixels of the picture, overscan included.
    pub whole: PixelRegion,
}

impl Tile {
    /// The settings of this part of a picture with `settings`.
    #[must_use]
    pub(crate) fn settings(self, settings: &str) -> String {
        if self.region == self.whole {
            return settings.to_owned();
        }
        let (region, whole) = (self.region, self.whole);
        format!(r#"{{"region":[{region}],"tile_of":[{whole}],"whole":{settings}}}"#)
    }

    /// The part that a file is, and the provenance of the picture it belongs to; `None` for a file
    /// that is no part of a picture.
    #[must_use]
    pub(crate) fn of(provenance: &Provenance) -> Option<(Self, Provenance)> {
        let rest = provenance.settings.strip_prefix(r#"{"region":["#)?;
        let (region, rest) = rest.split_once(r#"],"tile_of":["#)?;
        let (whole, rest) = rest.split_once(r#"],"whole":"#)?;
        let settings = rest.strip_suffix('}')?;
        let tile = Self {
            region: parse_region(region).ok()?,
            whole: parse_region(whole).ok()?,
        };
        let picture = Provenance {
            settings: settings.to_owned(),
            ..provenance.clone()
        };
        Some((tile, picture))
    }
}

/// A region as the command line has it: `X,Y,W,H`.
///
/// # Errors
/// What was found instead, or a region without pixels.
pub(crate) fn parse_region(text: &str) -> Result<PixelRegion, String> {
    let refused = || {
        format!("found {text:?}, expected X,Y,WIDTH,HEIGHT in pixels of the frame, say 0,0,640,120")
    };
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let [x, y, width, height] = parts[..] else {
        return Err(refused());
    };
    let region = PixelRegion {
        x_px: x.parse().map_err(|_| refused())?,
        y_px: y.parse().map_err(|_| refused())?,
        width_px: width.parse().map_err(|_| refused())?,
        height_px: height.parse().map_err(|_| refused())?,
    };
    region.checked().map_err(|error| error.to_string())
}

/// Which of how many tiles, both from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TileOfMany {
    /// Which, from 1.
    pub number: u32,
    /// How many there are.
    pub n_tiles: u32,
}

/// A tile as the command line has it: `I/N`, I from 1.
///
/// # Errors
/// What was found instead.
pub(crate) fn parse_tile(text: &str) -> Result<TileOfMany, String> {
    let parts = text.split_once('/').and_then(|(number, n_tiles)| {
        let number = number.trim().parse().ok()?;
        let n_tiles = n_tiles.trim().parse().ok()?;
        (1..=n_tiles)
            .contains(&number)
            .then_some(TileOfMany { number, n_tiles })
    });
    parts.ok_or_else(|| format!("found {text:?}, expected I/N with I from 1 to N, say 3/16"))
}

/// Which tiles of how many.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TilesOfMany {
    /// Which, from 1.
    pub numbers: FrameList,
    /// How many there are.
    pub n_tiles: u32,
}

/// Tiles as the command line has them: `3/16`, or `1-8/16`.
///
/// # Errors
/// What was found instead.
pub(crate) fn parse_tiles(text: &str) -> Result<TilesOfMany, String> {
    let parts = text.split_once('/').and_then(|(numbers, n_tiles)| {
        let numbers = FrameList::parse(numbers).ok()?;
        let n_tiles = n_tiles.trim().parse().ok()?;
        let all = numbers.iter().all(|number| (1..=n_tiles).contains(&number));
        all.then_some(TilesOfMany { numbers, n_tiles })
    });
    parts.ok_or_else(|| {
        format!(
            "found {text:?}, expected I/N or I-J/N with numbers from 1 to N, say 3/16 or 1-8/16"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_provenance_of_a_picture_comes_back_from_its_tile() {
        let picture = Provenance {
            tool: "niji render".to_owned(),
            settings: r#"{"camera":{"width_px":64},"text":"],\"whole\":"}"#.to_owned(),
            ..Provenance::default()
        };
        let whole = PixelRegion::frame(64, 48).grown(2).unwrap();
        let region = whole.bands(3).unwrap()[0];
        let tile = Tile { region, whole };
        let provenance = Provenance {
            settings: tile.settings(&picture.settings),
            ..picture.clone()
        };
        serde_json::from_str::<serde_json::Value>(&provenance.settings).unwrap();
        assert_eq!(Tile::of(&provenance), Some((tile, picture.clone())));
        assert_ne!(provenance.request_hash(), picture.request_hash());
        // The whole is no tile.
        let tile = Tile {
            region: whole,
            whole,
        };
        assert_eq!(tile.settings(&picture.settings), picture.settings);
        assert_eq!(Tile::of(&picture), None);
    }

    #[test]
    fn regions_and_tiles_are_read_as_people_type_them() {
        let region = parse_region(" -8, 16,640,120").unwrap();
        assert_eq!(region.to_string(), "-8,16,640,120");
        for text in [
            "",
            "1,2,3",
            "1,2,3,4,5",
            "1,2,-3,4",
            "1,2,0,4",
            "a,b,c,d",
            "1,2,3.5,4",
        ] {
            assert!(parse_region(text).is_err(), "{text}");
        }
        let tile = TileOfMany {
            number: 3,
            n_tiles: 16,
        };
        assert_eq!(parse_tile("3/16"), Ok(tile));
        for text in ["", "3", "0/4", "5/4", "1/0", "-1/4", "a/b"] {
            assert!(parse_tile(text).is_err(), "{text}");
            assert!(parse_tiles(text).is_err(), "{text}");
        }
        let tiles = |text| parse_tiles(text).map(|it| (it.numbers.to_string(), it.n_tiles));
        assert_eq!(tiles("3/16"), Ok(("3".to_owned(), 16)));
        assert_eq!(tiles("2,5-6 / 8"), Ok(("2,5-6".to_owned(), 8)));
        assert!(parse_tiles("1-9/8").is_err());
    }
}
