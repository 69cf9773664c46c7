"""From a scene to its record: prepare, draw, capture, judge, write down."""
