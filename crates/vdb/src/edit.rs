//! Metadata edited in a file whose voxels stay as they are: all other bytes are copied, whatever
//! their type and compression, and the offsets are moved.

use std::io::Read;
use std::io::Seek;
use std::io::SeekFrom;
use std::io::Write;
use std::ops::Range;

use crate::Error;
use crate::MetaValue;
use crate::input::Input;
use crate::items;
use crate::items::RawItem;
use crate::output::Output;
use crate::read::Archive;
use crate::read::Places;
use crate::read::UUID_LENGTH;
use crate::read::UUID_POSITION;
use crate::write::DERIVED_ITEMS;
use crate::write::uuid;

/// The one item that OpenVDB keeps for each grid and that says nothing about its voxels.
const CLASS_ITEM: &str = "class";

/// Bytes of the three offsets of a grid.
const OFFSETS_BYTES: usize = 24;

/// Bytes of the compression word in front of a grid's metadata.
const COMPRESSION_BYTES: u64 = 4;

/// Bytes that are copied at a time.
const CHUNK: usize = 1 << 18;

/// A change of one metadata item.
#[derive(Debug, Clone, PartialEq)]
pub struct MetadataEdit {
    /// Name of the grid, or of all grids that share it; `None` for an item of the file as a whole.
    pub grid: Option<String>,
    /// Name of the item.
    pub item: String,
    /// The new value; `None` takes the item out, if it is there.
    pub value: Option<MetaValue>,
}

/// Copy a file with other metadata. Voxels are neither decoded nor changed, so that this takes as
/// long as a copy and works for grids of types that are not read.
///
/// Everything else is kept but the UUID, which again becomes a hash of the content: a file written
/// by this crate comes out as if it had been written with the new metadata.
///
/// # Errors
/// [`Error::NoGrid`] for a grid that is not there, [`Error::DerivedItem`] for an item of a grid that
/// follows from its voxels or its name, and any error that says why the source is not a VDB file.
pub fn edit_metadata(
    mut source: impl Read + Seek,
    edits: &[MetadataEdit],
    output: impl Write + Seek,
) -> Result<(), Error> {
    let length = source.seek(SeekFrom::End(0))?;
    source.seek(SeekFrom::Start(0))?;
    let archive = Archive::open(source, length)?;
    check(edits, &archive)?;
    let Archive {
        input,
        has_offsets,
        items,
        entries,
        ..
    } = archive;
    let mut copy = Copy {
        input,
        output: Output::new(output)?,
        has_offsets,
    };
    copy.bytes(0..UUID_POSITION)?;
    copy.output.append(|bytes| bytes.extend([0; UUID_LENGTH]))?;
    copy.items(items.clone(), edits, None)?;
    let mut position = items.end;
    for entry in &entries {
        copy.grid(position, &entry.places, edits, &entry.header.name)?;
        position = entry.places.end;
    }
    copy.bytes(position..length)?;
    copy.output.finish(UUID_POSITION, uuid)
}

fn check<R>(edits: &[MetadataEdit], archive: &Archive<R>) -> Result<(), Error> {
    let names = || archive.entries.iter().map(|entry| &entry.header.name);
    for edit in edits {
        let Some(grid) = &edit.grid else { continue };
        if !names().any(|name| name == grid) {
            return Err(Error::NoGrid {
                grid: grid.clone(),
                found: names().cloned().collect(),
            });
        }
        let item = edit.item.as_str();
        if item != CLASS_ITEM && DERIVED_ITEMS.contains(&item) {
            let item = item.to_owned();
            return Err(Error::DerivedItem { item }.in_grid(grid));
        }
    }
    Ok(())
}

/// A file on its way into another.
struct Copy<R, W> {
    input: Input<R>,
    output: Output<W>,
    has_offsets: bool,
}

impl<R: Read + Seek, W: Write + Seek> Copy<R, W> {
    fn bytes(&mut self, range: Range<u64>) -> Result<(), Error> {
        self.input.seek(range.start)?;
        let mut left = range.end - range.start;
        while left > 0 {
            let step = left.min(CHUNK as u64) as usize;
            let window = self.input.window(step)?;
            self.output.append(|bytes| bytes.extend(&window[..step]))?;
            self.input.consume(step);
            left -= step as u64;
        }
        Ok(())
    }

    /// Copy metadata with the edits for a grid or for the file.
    fn items(
        &mut self,
        range: Range<u64>,
        edits: &[MetadataEdit],
        grid: Option<&str>,
    ) -> Result<(), Error> {
        self.input.seek(range.start)?;
        let mut items = items::read_raw(&mut self.input)?;
        for edit in edits.iter().filter(|edit| edit.grid.as_deref() == grid) {
            apply(edit, &mut items);
        }
        self.output.append(|bytes| items::push_raw(bytes, &items))
    }

    /// Copy a grid whose descriptor starts at a position.
    fn grid(
        &mut self,
        position: u64,
        places: &Places,
        edits: &[MetadataEdit],
        name: &str,
    ) -> Result<(), Error> {
        self.bytes(position..places.offsets)?;
        let offsets_position = self.output.position();
        let mut behind = places.offsets;
        if self.has_offsets {
            // As in a file that is written anew, the hash is taken before they are known.
            self.output
                .append(|bytes| bytes.extend([0; OFFSETS_BYTES]))?;
            behind += OFFSETS_BYTES as u64;
        }
        self.bytes(behind..places.items.start)?;
        let grid_position = self.output.position() - COMPRESSION_BYTES;
        self.items(places.items.clone(), edits, Some(name))?;
        let tree_position = self.output.position();
        self.bytes(places.items.end..places.end)?;
        if self.has_offsets {
            // An instance has no leaves; what stands in place of their offset is kept.
            let leaves = u64::try_from(places.leaves).ok();
            let leaves = leaves.filter(|leaves| (places.items.end..=places.end).contains(leaves));
            let leaves = match leaves {
                Some(leaves) => leaves - places.items.end + tree_position,
                None => places.leaves as u64,
            };
            let offsets = [grid_position, leaves, self.output.position()];
            let offsets = offsets.map(u64::to_le_bytes).concat();
            self.output.patch(offsets_position, offsets);
        }
        Ok(())
    }
}

/// Set, add or take out an item; items are in the order of their names.
fn apply(edit: &MetadataEdit, items: &mut Vec<RawItem>) {
    let name = edit.item.as_bytes();
    let place = items.iter().position(|item| item.name == name);
    let new = edit.value.as_ref().map(|value| RawItem::new(name, value));
    match (place, new) {
        (Some(place), Some(new)) => items[place] = new,
        (Some(place), None) => {
            items.remove(place);
        }
        (None, Some(new)) => {
            let behind = items.iter().position(|item| item.name.as_slice() > name);
            items.insert(behind.unwrap_or(items.len()), new);
        }
        (None, None) => {}
    }
}
