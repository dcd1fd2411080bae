"""Files with an owner's plan of stalls: GeoJSON, GeoPackage, OpenStreetMap's XML and DXF, read as one kind of value."""
