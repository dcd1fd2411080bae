CREATE TABLE lot (
  id VARCHAR(36) NOT NULL,
  name TEXT NOT NULL,
  outline TEXT NOT NULL,
  latitude FLOAT NOT NULL,
  longitude FLOAT NOT NULL,
  datum_is_pinned BOOLEAN NOT NULL,
  merged_into VARCHAR(36),
  made FLOAT NOT NULL,
  PRIMARY KEY (id),
  FOREIGN KEY(merged_into) REFERENCES lot (id)
)

CREATE TABLE label (
  lot VARCHAR(36) NOT NULL,
  label TEXT NOT NULL,
  stall VARCHAR(36) NOT NULL,
  PRIMARY KEY (lot, label)
)

CREATE TABLE outbox (
  seq INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
  kind TEXT NOT NULL,
  body TEXT NOT NULL,
  made FLOAT NOT NULL,
  sent FLOAT
)

CREATE TABLE share (
  id VARCHAR(36) NOT NULL,
  lot VARCHAR(36) NOT NULL,
  digest VARCHAR(64) NOT NULL,
  made FLOAT NOT NULL,
  ends FLOAT NOT NULL,
  taken_back FLOAT,
  PRIMARY KEY (id),
  UNIQUE (digest)
)

CREATE INDEX ix_share_lot ON share (lot)

CREATE TABLE pin (
  lot VARCHAR(36) NOT NULL,
  turn FLOAT NOT NULL,
  PRIMARY KEY (lot)
)

CREATE TABLE "plan" (
  lot VARCHAR(36) NOT NULL,
  revision INTEGER NOT NULL,
  whole INTEGER NOT NULL,
  PRIMARY KEY (lot)
)

CREATE TABLE edit (
  id VARCHAR(36) NOT NULL,
  lot VARCHAR(36) NOT NULL,
  version INTEGER NOT NULL,
  who TEXT NOT NULL,
  began FLOAT NOT NULL,
  touched FLOAT NOT NULL,
  closed FLOAT,
  change INTEGER,
  PRIMARY KEY (id)
)

CREATE UNIQUE INDEX ix_edit_open ON edit (lot) WHERE closed IS NULL

CREATE TABLE digest (
  part VARCHAR(8) NOT NULL,
  "key" VARCHAR(36) NOT NULL,
  digest BLOB,
  PRIMARY KEY (part, "key")
)
 WITHOUT ROWID

CREATE INDEX ix_digest_changed ON digest (part, "key") WHERE digest IS NULL

CREATE TABLE erased (
  id VARCHAR(64) NOT NULL,
  PRIMARY KEY (id)
)

CREATE TABLE layout (
  lot VARCHAR(36) NOT NULL,
  version INTEGER NOT NULL,
  valid_from FLOAT NOT NULL,
  why TEXT NOT NULL,
  who TEXT NOT NULL,
  PRIMARY KEY (lot, version),
  FOREIGN KEY(lot) REFERENCES lot (id)
)

CREATE TABLE survey (
  seq INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
  id VARCHAR(36) NOT NULL,
  origin TEXT NOT NULL,
  lot VARCHAR(36),
  layout INTEGER,
  placed VARCHAR(12) NOT NULL,
  candidates TEXT NOT NULL,
  began FLOAT NOT NULL,
  ended FLOAT NOT NULL,
  time_is_sure BOOLEAN NOT NULL,
  latitude FLOAT NOT NULL,
  longitude FLOAT NOT NULL,
  outline TEXT NOT NULL,
  north FLOAT,
  east FLOAT,
  turn FLOAT,
  free INTEGER NOT NULL,
  taken INTEGER NOT NULL,
  unknown INTEGER NOT NULL,
  stalls BLOB NOT NULL,
  program TEXT NOT NULL,
  simulated BOOLEAN NOT NULL,
  seen BLOB,
  doubt TEXT,
  accuracy FLOAT,
  blurred INTEGER,
  kind VARCHAR(8) NOT NULL,
  source VARCHAR(12) NOT NULL,
  source_name TEXT NOT NULL,
  limits TEXT NOT NULL,
  UNIQUE (id),
  UNIQUE (origin),
  FOREIGN KEY(lot) REFERENCES lot (id)
)

CREATE INDEX ix_survey_lot ON survey (lot)

CREATE TABLE zone (
  id VARCHAR(36) NOT NULL,
  lot VARCHAR(36) NOT NULL,
  name TEXT NOT NULL,
  kind TEXT NOT NULL,
  outline TEXT NOT NULL,
  begins INTEGER NOT NULL,
  ends INTEGER,
  PRIMARY KEY (id),
  FOREIGN KEY(lot) REFERENCES lot (id)
)

CREATE INDEX ix_zone_lot ON zone (lot)

CREATE TABLE delivery (
  message INTEGER NOT NULL,
  target VARCHAR(16) NOT NULL,
  tries INTEGER NOT NULL,
  first FLOAT NOT NULL,
  next FLOAT NOT NULL,
  sent FLOAT,
  given_up FLOAT,
  PRIMARY KEY (message, target),
  FOREIGN KEY(message) REFERENCES outbox (seq) ON DELETE CASCADE
)

CREATE TABLE change (
  seq INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
  kind TEXT NOT NULL,
  lot VARCHAR(36) NOT NULL,
  who TEXT NOT NULL,
  made FLOAT NOT NULL,
  body TEXT NOT NULL,
  state VARCHAR(8) NOT NULL,
  undone FLOAT,
  edit VARCHAR(36),
  revision INTEGER,
  FOREIGN KEY(edit) REFERENCES edit (id)
)

CREATE INDEX ix_change_edit ON change (edit)

CREATE INDEX ix_change_lot ON change (lot)

CREATE TABLE stall (
  "key" INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
  id VARCHAR(36) NOT NULL,
  lot VARCHAR(36) NOT NULL,
  label TEXT NOT NULL,
  north FLOAT NOT NULL,
  east FLOAT NOT NULL,
  angle FLOAT NOT NULL,
  width FLOAT NOT NULL,
  length FLOAT NOT NULL,
  kind TEXT NOT NULL,
  is_confirmed BOOLEAN NOT NULL,
  begins INTEGER NOT NULL,
  ends INTEGER,
  first_survey INTEGER,
  first_id INTEGER,
  UNIQUE (id),
  FOREIGN KEY(lot) REFERENCES lot (id),
  FOREIGN KEY(first_survey) REFERENCES survey (seq)
)

CREATE INDEX ix_stall_place ON stall (lot, north)

CREATE INDEX ix_stall_lot ON stall (lot)

CREATE TABLE looks (
  survey INTEGER NOT NULL,
  at FLOAT NOT NULL,
  stalls BLOB NOT NULL,
  PRIMARY KEY (survey),
  FOREIGN KEY(survey) REFERENCES survey (seq) ON DELETE CASCADE
)

CREATE TABLE dropped (
  id VARCHAR(36) NOT NULL,
  lot VARCHAR(36) NOT NULL,
  survey INTEGER NOT NULL,
  does VARCHAR(5) NOT NULL,
  stall VARCHAR(36),
  north FLOAT,
  east FLOAT,
  angle FLOAT,
  width FLOAT,
  length FLOAT,
  PRIMARY KEY (id),
  FOREIGN KEY(survey) REFERENCES survey (seq)
)

CREATE INDEX ix_dropped_lot ON dropped (lot)

CREATE TABLE former (
  lot VARCHAR(36) NOT NULL,
  stall INTEGER NOT NULL,
  ends INTEGER NOT NULL,
  label TEXT NOT NULL,
  north FLOAT NOT NULL,
  east FLOAT NOT NULL,
  angle FLOAT NOT NULL,
  width FLOAT NOT NULL,
  length FLOAT NOT NULL,
  kind TEXT NOT NULL,
  is_confirmed BOOLEAN NOT NULL,
  PRIMARY KEY (lot, stall, ends),
  FOREIGN KEY(stall) REFERENCES stall ("key")
)
 WITHOUT ROWID

CREATE INDEX ix_former_stall ON former (stall)

CREATE TABLE observation (
  survey INTEGER NOT NULL,
  stall INTEGER NOT NULL,
  looked FLOAT NOT NULL,
  taken FLOAT NOT NULL,
  state VARCHAR(8) NOT NULL,
  seen INTEGER NOT NULL,
  PRIMARY KEY (survey, stall),
  FOREIGN KEY(survey) REFERENCES survey (seq),
  FOREIGN KEY(stall) REFERENCES stall ("key")
)
 WITHOUT ROWID

CREATE INDEX ix_observation_stall ON observation (stall)

CREATE TRIGGER looks_insert AFTER INSERT ON observation BEGIN DELETE FROM looks WHERE survey = NEW.survey; END

CREATE TRIGGER looks_update AFTER UPDATE ON observation BEGIN DELETE FROM looks WHERE survey = NEW.survey; END

CREATE TRIGGER looks_delete AFTER DELETE ON observation BEGIN DELETE FROM looks WHERE survey = OLD.survey; END

CREATE TRIGGER outbox_layout AFTER INSERT ON layout BEGIN INSERT INTO outbox (kind, body, made) VALUES ('layout', '{"lot":"' || NEW.lot || '","version":' || NEW.version || '}', NEW.valid_from); END

CREATE TRIGGER digest_survey_insert AFTER INSERT ON survey BEGIN INSERT INTO digest (part, key) VALUES ('survey', CAST(NEW.seq AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_survey_update AFTER UPDATE ON survey BEGIN INSERT INTO digest (part, key) VALUES ('survey', CAST(OLD.seq AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('survey', CAST(NEW.seq AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_survey_delete AFTER DELETE ON survey BEGIN INSERT INTO digest (part, key) VALUES ('survey', CAST(OLD.seq AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_observation_insert AFTER INSERT ON observation BEGIN INSERT INTO digest (part, key) VALUES ('survey', CAST(NEW.survey AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_observation_update AFTER UPDATE ON observation BEGIN INSERT INTO digest (part, key) VALUES ('survey', CAST(OLD.survey AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('survey', CAST(NEW.survey AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_observation_delete AFTER DELETE ON observation BEGIN INSERT INTO digest (part, key) VALUES ('survey', CAST(OLD.survey AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_looks_insert AFTER INSERT ON looks BEGIN INSERT INTO digest (part, key) VALUES ('survey', CAST(NEW.survey AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_looks_update AFTER UPDATE ON looks BEGIN INSERT INTO digest (part, key) VALUES ('survey', CAST(OLD.survey AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('survey', CAST(NEW.survey AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_looks_delete AFTER DELETE ON looks BEGIN INSERT INTO digest (part, key) VALUES ('survey', CAST(OLD.survey AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_dropped_insert AFTER INSERT ON dropped BEGIN INSERT INTO digest (part, key) VALUES ('survey', CAST(NEW.survey AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_dropped_update AFTER UPDATE ON dropped BEGIN INSERT INTO digest (part, key) VALUES ('survey', CAST(OLD.survey AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('survey', CAST(NEW.survey AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_dropped_delete AFTER DELETE ON dropped BEGIN INSERT INTO digest (part, key) VALUES ('survey', CAST(OLD.survey AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_lot_insert AFTER INSERT ON lot BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.id AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_lot_update AFTER UPDATE ON lot BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.id AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.id AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_lot_delete AFTER DELETE ON lot BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.id AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_layout_insert AFTER INSERT ON layout BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_layout_update AFTER UPDATE ON layout BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_layout_delete AFTER DELETE ON layout BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_stall_insert AFTER INSERT ON stall BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_stall_update AFTER UPDATE ON stall BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_stall_delete AFTER DELETE ON stall BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_former_insert AFTER INSERT ON former BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_former_update AFTER UPDATE ON former BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_former_delete AFTER DELETE ON former BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_label_insert AFTER INSERT ON label BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_label_update AFTER UPDATE ON label BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_label_delete AFTER DELETE ON label BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_zone_insert AFTER INSERT ON zone BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_zone_update AFTER UPDATE ON zone BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_zone_delete AFTER DELETE ON zone BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_share_insert AFTER INSERT ON share BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_share_update AFTER UPDATE ON share BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_share_delete AFTER DELETE ON share BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_pin_insert AFTER INSERT ON pin BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_pin_update AFTER UPDATE ON pin BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_pin_delete AFTER DELETE ON pin BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_plan_insert AFTER INSERT ON plan BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_plan_update AFTER UPDATE ON plan BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_plan_delete AFTER DELETE ON plan BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_edit_insert AFTER INSERT ON edit BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_edit_update AFTER UPDATE ON edit BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('lot', CAST(NEW.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_edit_delete AFTER DELETE ON edit BEGIN INSERT INTO digest (part, key) VALUES ('lot', CAST(OLD.lot AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_change_insert AFTER INSERT ON change BEGIN INSERT INTO digest (part, key) VALUES ('change', CAST(NEW.seq AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_change_update AFTER UPDATE ON change BEGIN INSERT INTO digest (part, key) VALUES ('change', CAST(OLD.seq AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('change', CAST(NEW.seq AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_change_delete AFTER DELETE ON change BEGIN INSERT INTO digest (part, key) VALUES ('change', CAST(OLD.seq AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_outbox_insert AFTER INSERT ON outbox BEGIN INSERT INTO digest (part, key) VALUES ('outbox', CAST(NEW.seq AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_outbox_update AFTER UPDATE ON outbox BEGIN INSERT INTO digest (part, key) VALUES ('outbox', CAST(OLD.seq AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('outbox', CAST(NEW.seq AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_outbox_delete AFTER DELETE ON outbox BEGIN INSERT INTO digest (part, key) VALUES ('outbox', CAST(OLD.seq AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_delivery_insert AFTER INSERT ON delivery BEGIN INSERT INTO digest (part, key) VALUES ('outbox', CAST(NEW.message AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_delivery_update AFTER UPDATE ON delivery BEGIN INSERT INTO digest (part, key) VALUES ('outbox', CAST(OLD.message AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; INSERT INTO digest (part, key) VALUES ('outbox', CAST(NEW.message AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END

CREATE TRIGGER digest_delivery_delete AFTER DELETE ON delivery BEGIN INSERT INTO digest (part, key) VALUES ('outbox', CAST(OLD.message AS TEXT)) ON CONFLICT (part, key) DO UPDATE SET digest = NULL WHERE digest IS NOT NULL; END
