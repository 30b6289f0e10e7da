"""A reader for rerun files."""


def read_columns(path):
    """Return entity -> component -> values of each row, and entity -> timelines, of an .rrd file."""
    from rerun.chunk import RrdReader

    found, timelines = {}, {}
    for chunk in RrdReader(path).stream().to_chunks():
        batch = chunk.to_record_batch()
        entity = found.setdefault(str(chunk.entity_path).strip("/"), {})
        timelines.setdefault(str(chunk.entity_path).strip("/"), set()).update(chunk.timeline_names)
        for name in batch.schema.names:
            entity.setdefault(name.rpartition(":")[2], []).extend(batch.column(name).to_pylist())
    return found, timelines
