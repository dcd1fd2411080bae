### The words of the operator page in English, in Fluent's syntax (https://projectfluent.org/fluent/guide).
###
### A line "key = words" is one message. { $name } is a value that the page puts in: a number with its unit, a name, or a
### time. A value before "->" chooses between the lines below it: by number (one, other), or by one of the names given.
### Sentences of the drone's program (messages, checks, reasons) come from the drone and stand in no file of the page.

## Numbers and units

# $value: a number in the language's own digits.
length =
    { $units ->
        [feet] { $value } ft
       *[metres] { $value } m
    }
length-km = { $value } km
speed =
    { $units ->
        [feet] { $value } mph
       *[metres] { $value } m/s
    }
area =
    { $units ->
        [feet] { $value } ft²
       *[metres] { $value } m²
    }
# Larger areas.
large-area =
    { $units ->
        [feet] { $value } acres
       *[metres] { $value } ha
    }
# Two sides of an area, the second with its unit: 150 × 146 m
extent = { $one } × { $other }
seconds = { $value } s
minutes = { $value } min
minutes-seconds = { $minutes } min { $seconds } s
percent = { $value } %
volts = { $value } V
# Sizes of files.
file-size =
    { $unit ->
        [B] { $value } B
        [kB] { $value } kB
        [MB] { $value } MB
       *[GB] { $value } GB
    }
latitude =
    { $side ->
        [north] { $degrees }° N
       *[south] { $degrees }° S
    }
longitude =
    { $side ->
        [east] { $degrees }° E
       *[west] { $degrees }° W
    }
place = { $latitude }, { $longitude }
# So far east or west of a place.
offset-east =
    { $side ->
        [east] { $length } E
       *[west] { $length } W
    }
offset-north =
    { $side ->
        [north] { $length } N
       *[south] { $length } S
    }
offset = { $east }, { $north }
wind =
    { $from ->
        [north] { $speed } from the north
        [north-east] { $speed } from the north-east
        [east] { $speed } from the east
        [south-east] { $speed } from the south-east
        [south] { $speed } from the south
        [south-west] { $speed } from the south-west
        [west] { $speed } from the west
       *[north-west] { $speed } from the north-west
    }
# So old is a value: 6 s old
age = { $age } old

## Actions of the bar: the label of a button, short, and the note below it

arm = Arm
arm-note = Start the motors
checks-passed =
    { $checks ->
        [one] 1 check passed
       *[other] { $checks } checks passed
    }
already-armed = Already armed
checks-failed =
    { $checks ->
        [one] 1 check failed
       *[other] { $checks } checks failed
    }
disarm = Disarm
disarm-note = Stop the motors
resume = Resume
resume-note = Take over from the pilot
takeoff = Take off
takeoff-note = To the set height
disarmed-by-itself = The motors went off by themselves: the autopilot does so when no take-off follows within seconds of Arm. Arm again to take off.
takeoff-disarmed = The motors went off by themselves: Arm again
takeoff-to = To { $height }
explore = Explore
explore-note = See the whole lot
# The lot is known: the length of its flight, and its time.
explore-again = Again, { $distance }
explore-again-time = Again, { $distance }, { $time }
explore-again-batteries = Again, { $distance }, { $time }, { $batteries } batteries
move = Move
move-note =
    { $pointer ->
        [finger] Then tap the map
       *[mouse] Then click the map
    }
move-now =
    { $pointer ->
        [finger] Now tap the map
       *[mouse] Now click the map
    }
move-running = To a new place
home = Return home
home-note = And land there
home-distance = { $distance }, { $time } to the ground
home-without-link = No link: does it itself
land = Land
land-note = Straight down
land-running = Landing
hold = Hold
hold-note = Stop and stay
running = Running
running-percent = Running, { $percent }
more-actions = More actions

# Why something cannot be done.
no-link = No link
on-the-ground = On the ground
not-possible = Not possible here
not-in-control = Not in control
you-are-viewer = You are a viewer
not-known-yet = Not known yet

## Who has control

viewer-title = You are watching as a viewer.
viewer-text = A viewer sees everything and commands nothing.
free-title = Nobody has control.
free-text = Take control to fly. You can watch without.
lost-title = The operator in control is lost.
lost-text = Take control to fly. Return home and Land are free to all.
taken-text = It was taken: you were lost, or did not answer. You can Hold the drone at any time.
watching-title = You are watching. Someone else has control.
watching-text = You can Hold the drone at any time.
take-control = Take control
ask-for-control = Ask for control
take-control-now = Take control now
withdraw = Withdraw
give = Give
keep = Keep
give-control = Give control
keep-control = Keep control
give-back = Give back
give-back-control = Give back control
# Short, beside the symbol of a person.
you-have-control = You have control
nobody-has-control = Nobody has control
operator-lost = Operator lost
operator-in-control-lost = The operator in control is lost
someone-has-control = Someone else has control
control-not-known = Control is not known
you-had-control = You had control
no-control = No control
you-have-control-text = Others watch; every operator may Hold.
take-in-bar = Take it in the bar at the bottom.
give-back-first = Give back control first

# Questions for control. $name: an operator.
was-asked = { $name } was asked for control.
does-not-answer = { $name } does not answer.
you-can-take-in = Without an answer you can take control in { $time }.
you-can-take-now = You can take control. The drone goes on with what it does.
asks-for-control = { $name } asks for control.
other-can-take-in = Without an answer { $name } can take control in { $time }.
other-can-take-now = Without an answer { $name } can take control now.
release-title = Give back control in the air?
release-text = It stops and holds, then returns home and lands, unless somebody takes control.
release-text-for = It stops and holds for { $time }, then returns home and lands, unless somebody takes control.

# A plan of the lot that somebody changed in flight. $name: who; $lot: of which lot.
plan-changed = Plan of { $lot } changed, signed { $name }. Fly it?
fly-plan = Fly it
leave-plan = Leave it

# The page of the one in control is hidden while the drone flies a task.
hidden-warning = The page is hidden: look at it, or the drone returns.

# What others did.
stopped-by = Stopped by { $name }.
returning-by = Returning home, asked by { $name }.
landing-by = Landing, asked by { $name }.
took-control = { $name } took control: you were lost, or did not answer.
you-have-control-now = You have control.
other-has-control = { $name } has control.
other-keeps-control = { $name } keeps control.
operator-keeps-control = The operator keeps control.

## Questions in the bar: the question, what it means, the words on the slide

slide-help = Slide to the right, or keep Enter pressed for a second
slide-missed = The page was busy: again
arm-question = Start the motors?
arm-meaning = Keep clear of the propellers.
arm-slide = Slide to arm
takeoff-question = Take off?
takeoff-question-to = Take off to { $height }?
takeoff-meaning = Straight up from where it stands.
takeoff-slide = Slide to take off
explore-question = Explore the whole lot?
explore-meaning = It flies by itself inside the fence. Hold stops it.
explore-slide = Slide to explore
home-question = Return home and land there?
home-slide = Slide to return
land-question = Land straight down?
land-slide = Slide to land
overrules = The remote control is overruled.
new-survey = New survey
new-survey-question = Begin a new survey?
new-survey-meaning = The map begins empty. The last survey stays stored on the drone.
new-survey-slide = Slide to begin
resume-question = Resume, taking over from the remote control?
resume-meaning = It stops and stays where it is.
resume-slide = Slide to resume
move-slide = Slide to move
cancel = Cancel
close = Close

## Move

# $to: direction on the compass. $then: whether it climbs or stays at its height, which is $height.
journey =
    { $to ->
        [north] { $distance } north
        [north-east] { $distance } north-east
        [east] { $distance } east
        [south-east] { $distance } south-east
        [south] { $distance } south
        [south-west] { $distance } south-west
        [west] { $distance } west
       *[north-west] { $distance } north-west
    }{ $then ->
        [climbing] , climbing to { $height }
        [sinking] , sinking to { $height }
        [staying] , staying at { $height }
       *[unknown] { "" }
    }
move-question = Move { journey }?
# A stall is to be looked at again. The line says how the drone flies there.
look-again-question = Look at stall { $stall } again?
look-again-line = Fly { journey }.
# Typed in place of a click on the map. $unit: m or ft.
move-typed = Or type how far
move-north = North, { $unit }
move-east = East, { $unit }
move-height = Height, { $unit }
move-from = From
move-from-drone = the drone
move-from-home = where it was armed
move-set = Set place
move-no-number = North, East: give a number, below 0 for south or west.
move-height-bounds = Height: give a number from { $lowest } to { $highest }, or none.
move-height-straight = At a height of its own it flies straight
home-not-known = Where it was armed is not known.
move-pill = { $distance }, { $time }
inside-lot = Inside the lot
inside-fence = Anywhere inside the fence
where-may-fly = Where it may fly
outside-fence = Outside the fence
in-zone = In a zone or its margin
leaves-fence = The straight path there leaves the fence
crosses-zone = The straight path there crosses a zone
no-place-in-lot = Not a place inside the lot
no-route = There is no route there.
choose-inside = Outside the fence. Choose a place inside the dotted line.
choose-out-of-zone = In a zone or its margin. Choose a place inside the dotted line and out of zones.
# $time: how long it flies.
takes = { $time }.
takes-battery = { $time }, about { $percent } battery.
stays-in-lot = Stays inside the lot.
stays-in-lot-distance = Stays inside the lot, { $distance } along the route.
stays-in-fence = Inside the fence, lot or not.
exploring-stops = Exploring stops.
place-not-known = Where the drone is, is not known.
wait-for-position = Wait for its position.

## The line at the top: state, free stalls, battery, height, link

state-idle = On the ground
state-configure = Storing heights
state-arm = Arming
state-armed = Armed
state-takeoff = Taking off
state-hover = Holding
state-explore = Exploring
state-move = Moving
state-home = Returning home
state-land = Landing
state-operator-lost = Operator lost
state-free = Nobody has control
state-manual = Flown by hand
not-connected = Not connected
waiting-for-drone = Waiting for the drone
looking-for-drone = Looking for the drone
# $state: one of the states above, in small letters. $age: so long ago.
was-in-state = was { $state } { $age } ago
autopilot-silent = Autopilot silent
autopilot-silent-text = The drone's computer does not hear it
cutting-motors = Cutting motors
cutting-motors-text = Sent until the motors are off
cut-not-confirmed = Cut not confirmed
cut-not-confirmed-text = The motors may still run
fell = Motors off in the air
fell-text = Look at the drone, then clear it to arm again
motors-cut = Motors cut
motors-cut-text = Clear it to arm again
fix-to-arm =
    { $checks ->
        [one] 1 check failed. Fix it to arm.
       *[other] { $checks } checks failed. Fix them to arm.
    }
landed = Landed
motors-off-since = Motors off since { $time }
# $time: a span, to the end of the survey.
seen-of-outline = { $percent } of the outline seen
seen-of-outline-time = { $percent } of the outline seen, about { $time } to go
# Its end is not known: how much more lot comes in sight is not.
found-so-far =
    { $stalls ->
        [one] 1 stall so far
       *[other] { $stalls } stalls so far
    }
found-so-far-time =
    { $stalls ->
        [one] 1 stall so far, { $time } for what is in sight
       *[other] { $stalls } stalls so far, { $time } for what is in sight
    }
# The same for a narrow page.
seen-of-outline-short = { $percent } seen
seen-of-outline-time-short = { $percent } seen, { $time } to go
found-so-far-short = { $stalls } so far
found-so-far-time-short = { $stalls } so far, { $time } in sight
picture-old = Picture { $age } old.
free-stalls = free stalls
free-at = free, at { $time }
# In a lot of sections alone: vehicles of places, as "12/20"
parked = parked
parked-at = parked, at { $time }
battery = battery
# Behind the time until it must return: the charge.
battery-percent = until return, { $percent }
# After the age of an old value.
then-percent = , { $percent }
height = height
link-none = no link
link-lost = link lost
link-slow = link, slow
link-good = link, good
link-autopilot-silent = autopilot silent
link-autopilot-slow = autopilot, slow
simulation-mark = SIMULATION
simulation = Simulation
no-real-drone = No real drone flies.
desk = Desk
desk-mark = DESK
desk-words = Lots and plans. No drone is here.
some-lots = Your lots
some-lots-mark = YOUR LOTS
some-lots-words = You are logged in as { $name }.
some-lots-no-drone-title = Not with this login
some-lots-no-drone = Your login is for some lots. Drone, live picture and recordings need the token of a role for all lots: log out, and log in with that.
menu = Menu
skip = Skip
skip-to-actions = Skip to the actions
title = { $state } – Parking Lot Hawk
title-simulation = { $state } – Parking Lot Hawk (simulation)

## Cutting the motors

cut-motors = Cut motors
cut-question = Cut motors?
cut-falls = The drone falls at once. Only if it is about to hurt someone.
cut-falls-from = The drone falls from { $height } at once. Only if it is about to hurt someone.
cut-instead = To stop it safely use Hold or Land.
cut-press = Keep pressed 1 s to cut
cut-missed = The page was too busy to follow the press: press again.
cut-not-allowed = The drone did not allow it.
cut-too-long = That took too long. Cancel and begin again.

## The banner: what is wrong with the link, and what the drone does by its settings

never-connected-title = Not connected to the drone
never-connected-text = Is it switched on and in reach? This page keeps trying by itself.
no-word-title = No word from the drone for { $age }
was-on-ground = It was on the ground when it was last heard.
was-flown-by-hand = It was flown with the remote control when it was last heard.
use-remote = To take over, use the remote control.
goes-on-home = By its settings it goes on home and lands there.
goes-on-landing = By its settings it goes on landing.
goes-on-otherwise = Another operator had control, or it was already waiting: it goes on by its settings.
returning-since = By its settings it has been returning home since { $time }, and lands there.
holds-now = By its settings it now holds its place.
holds-at = By its settings it goes on until { $time }, then holds its place.
returns-at = At { $time } it returns home and lands.
autopilot-acts = If its computer stopped, the autopilot acts by its own failsafe.
autopilot-acted-sooner = If its computer stopped, the autopilot acted sooner by its own failsafe.
autopilot-acts-sooner = If its computer stopped, the autopilot acts sooner by its own failsafe.
mark-lost = lost
mark-holds = holds
# A time follows: 12 s
mark-returns-in = returns home at the latest in
mark-returned = returned home
connect = Connect
autopilot-lost-title = The drone's computer does not hear the autopilot
autopilot-lost-flying = By its settings the autopilot returns home when it hears nothing. To take over, use the remote control.
autopilot-lost-ground = Is the autopilot switched on and its cable in place? The drone's computer keeps trying.
operator-was-lost = The operator was lost
holds-its-place = It holds its place.
then-returns = Then it returns home and lands.
returns-in = In { $time } it returns home and lands.
take-control-to-go-on = Take control to go on.
cut-unconfirmed-title = Cutting the motors is not confirmed
cut-unconfirmed-text = The drone did not say that the motors are off. Cut motors again if it is still needed.

## The survey on the map, before the next flight

survey-on-map = A survey is on the map
# $area: such as 1.2 ha
earlier =
    { $stalls ->
        [one] 1 stall. The next flight goes on with it.
       *[other] { $stalls } stalls. The next flight goes on with it.
    }
earlier-on =
    { $stalls ->
        [one] 1 stall on { $area }. The next flight goes on with it.
       *[other] { $stalls } stalls on { $area }. The next flight goes on with it.
    }
open-last-survey = Open last survey
continue-survey = Continue survey

## Stalls

free = free
taken = taken
unknown = unclear
suggested = suggested
# Below numbers of stalls.
legend-free = free
legend-taken = taken
legend-unknown = unclear
stalls = Stalls
unclear-probably-free = unclear, probably free
unclear-probably-taken = unclear, probably taken
almost-surely-free = almost surely free
almost-surely-taken = almost surely taken
probably-free = probably free
probably-taken = probably taken
suggested-too = { $stalls } suggested besides
stood-in = No marks here. A car stood here in { $passes } passes.
not-seen-itself = not seen itself
not-seen-from-row = Not seen itself, found from its row.
seen-in =
    { $pictures ->
        [one] Seen in 1 picture only.
       *[other] Seen in { $pictures } pictures only.
    }
seen-in-last =
    { $pictures ->
        [one] Seen in 1 picture only, last at { $time }.
       *[other] Seen in { $pictures } pictures only, last at { $time }.
    }
last-seen = Last seen at { $time }.
stall-number = Stall { $stall }
stall-picture = Picture of stall { $stall }
look-again = Look again
# A stall's place, from home.
from-home-by =
    { $to ->
        [north] { $distance } north of home
        [north-east] { $distance } north-east of home
        [east] { $distance } east of home
        [south-east] { $distance } south-east of home
        [south] { $distance } south of home
        [south-west] { $distance } south-west of home
        [west] { $distance } west of home
       *[north-west] { $distance } north-west of home
    }
no-stall-yet = No stall was found yet.
stalls-as-table = Stalls as a table
stalls-caption =
    { $stalls ->
        [one] 1 stall, free ones first, the nearest to home first
       *[other] { $stalls } stalls, free ones first, the nearest to home first
    }
column-stall = Stall
column-state = State
column-place = Place
column-seen = Seen
show-stall = Show stall { $stall } on the map
show-more = Show more
show-survey = Show survey
# Said once the lot found was seen whole; it does not know of others.
free-between = { $low } to { $high } are free in the lot found
counted-up-to = Counted up to { $time }
stalls-found =
    { $stalls ->
        [one] 1 stall found
       *[other] { $stalls } stalls found
    }
stalls-found-all =
    { $stalls ->
        [one] 1 stall found, the lot found seen whole
       *[other] { $stalls } stalls found, the lot found seen whole
    }
stalls-found-seen =
    { $stalls ->
        [one] 1 stall found, { $percent } seen of the lot found
       *[other] { $stalls } stalls found, { $percent } seen of the lot found
    }

## The survey after landing

survey = Survey
survey-so-far = Survey so far
survey-so-far-all = Survey so far, the lot found seen whole
landed-at = Landed at { $time }
landed-at-all = Landed at { $time }, the lot found seen whole
close-survey = Close survey
# Large: the number of free stalls. Small after it: of how many.
hero-free = { $free } free
hero-of =
    { $stalls ->
        [one] of 1 stall found
       *[other] of { $stalls } stalls found
    }
free-share = free, { $percent }
taken-share = taken, { $percent }
unknown-share = unclear, { $percent }
in-the-air = in the air
flown = flown
lot-found = lot found
of-it-seen = of it seen
downloads = Downloads
file-table = Table
file-stalls = Stalls for maps
file-picture = Picture of the lot
file-recording = Recording
# $kind: CSV, JPEG
file-kind-size = { $kind }, { $size }
lots-over-time = Over time
lots = Lots
lot-stalls =
    { $stalls ->
        [one] 1 stall
       *[other] { $stalls } stalls
    }
lot-sections =
    { $sections ->
        [one] 1 section
       *[other] { $sections } sections
    }
lot-surveys =
    { $surveys ->
        [one] 1 survey
       *[other] { $surveys } surveys
    }
# $when: a day
lot-seen = · last seen { $when }
clock-of = { $city } time
lot-clock = Clock
lot-clock-of-place = That of its place
link-shows-nothing = This link shows nothing
link-ended = This link has ended, or was taken back. Ask the person who sent it for another one.
link-too-often = Too many wrong links came from your network. Wait a minute, then load the page again.
rename = Name and clock
newest-survey = Newest survey
newest-survey-of = Newest survey: { $name }
rename-lot = Name and clock of { $name }
name-of-lot = Name of the lot
which-lot = Which lot is it?
# $when: a day
survey-of = Survey of { $when }
a-new-lot = A new lot
stalls-begin =
    { $stalls ->
        [one] 1 stall begins
       *[other] { $stalls } stalls begin
    }
stalls-end =
    { $stalls ->
        [one] 1 stall ends
       *[other] { $stalls } stalls end
    }
stalls-added =
    { $stalls ->
        [one] 1 stall added
       *[other] { $stalls } stalls added
    }
stalls-removed =
    { $stalls ->
        [one] 1 stall removed
       *[other] { $stalls } stalls removed
    }
stalls-changed =
    { $stalls ->
        [one] 1 stall changed
       *[other] { $stalls } stalls changed
    }
areas-changed = zones and sections: { $names }
changed-on-drone = By the operator of { $drone }, while the plan was changed here
same-ground = { $name } is on the ground of this lot
same-ground-share = { $share } of the smaller one
merge-lot = Merge into this lot
show-on-map = Show on the map
take-over-changes = Take over
drop-changes = Drop
begins = begins
ends = ends
end-confirmed =
    { $stalls ->
        [one] End the confirmed one too
       *[other] End the { $stalls } confirmed ones too
    }
where-was-survey = Where was this survey?
place-number = Place { $place }
here = Here
here-place = Here: place { $place }
stalls-of-lot = stalls of the lot
stalls-of-survey = stalls of the survey

## The plan of a lot, corrected by a person

correct-plan = Correct the plan
# $name: of the lot
correct-plan-of = Correct the plan: { $name }
survey-again = Survey again
survey-again-of = Survey again: { $name }
survey-again-taken = { $name } will be surveyed again by Explore.
# $name: of the lot
choose-for-round = { $name } in a flight over several lots
survey-again-round = Survey { $lots } lots again in one flight
survey-again-due = Survey all that are due
round-taken = The lots will be surveyed again by Explore, in one flight.
day-plan = The day's plan
day-plan-batteries = Full batteries
day-plan-wind = Wind, m/s
day-plan-gust = Gusts, m/s
day-plan-cloud = Cloud, %
day-plan-rain = Rain, mm
day-plan-file = Or a forecast by hour (JSON)
day-plan-ask = Plan the day
day-plan-none = No survey is due in the next 24 hours.
day-plan-no-json = The forecast is no JSON: look for a comma or a bracket too many.
# $names: of the lots
day-plan-start = { $start } to { $end }: { $names }
day-plan-no-start = No start: { $names }
day-plan-due = due { $due }
# $time: how long the round takes
day-plan-need = { $time }, { $distance }, batteries: { $batteries }
# $times: at which it cannot start; the reasons follow
day-plan-not-at = Not at { $times }:
day-plan-choose = Choose
day-plan-choose-of = Choose for one flight: { $names }
plan-unanswered = The drone did not answer: the plan could not be read.
# $name: of the lot
plan-of = Plan of { $name }
# $guessed: labels that no person gave or confirmed
plan-counts =
    { $stalls ->
        [one] 1 stall, { $confirmed } confirmed
       *[other] { $stalls } stalls, { $confirmed } confirmed
    }{ $guessed ->
        [0] { "" }
        [one] ; 1 label is our guess
       *[other] ; { $guessed } labels are our guess
    }
# $time: hours and minutes
plan-you-edit = You edit since { $time }.
# $who: another person
plan-other-edits = { $who } edits since { $time }.
# Name of a person who has given none.
plan-nameless = Operator
plan-take-over = Take over
plan-go-on = Go on editing
plan-nobody-edits = Nobody edits. Your first change begins an edit.
plan-no-edit = Your edit was closed.
plan-opening = Opens the edit…
plan-waits =
    { $steps ->
        [one] 1 change waits.
       *[other] { $steps } changes wait.
    }
plan-no-answer = The drone does not answer.
plan-by-gnss = Placed by GNSS alone: the plan may lie some metres off the picture.
plan-by-itself = There is no map yet: the plan is shown by itself.
plan-steps-lost =
    { $steps ->
        [one] 1 change of the plan was not done.
       *[other] { $steps } changes of the plan were not done.
    }
plan-as-before = The plan is as it was.
# $version: its number
plan-closed = The plan is closed as version { $version } of the layout.
plan-leave-aloud = Leave the plan; your edit stays open
plan-close = Close the edit
plan-why = Reason, if any
plan-tools = Plan tools
plan-tool-choose = Choose
plan-tool-box = Box
plan-tool-stall = Add stall
plan-tool-row = Add row
plan-tool-area = No stalls
plan-tool-area-aloud = No stalls: an area without stalls
plan-tool-zone = Zone
plan-tool-section = Section
plan-redo = Redo
plan-choose-line =
    { $pointer ->
        [finger] Tap stalls; tap twice for a row. Drag what is chosen.
       *[mouse] Click a stall, with Shift several; double-click for its row; drag with Shift for a box. Drag what is chosen, or use the arrow keys. R turns, Delete removes.
    }
plan-box-line = Drag a box over stalls.
plan-stall-line =
    { $pointer ->
        [finger] Tap where the stall is. It snaps to the row beside it.
       *[mouse] Click where the stall is. It snaps to the row beside it; with Alt it does not.
    }
plan-row-begin =
    { $pointer ->
        [finger] Tap one end of the row's front.
       *[mouse] Click one end of the row's front.
    }
plan-row-end =
    { $pointer ->
        [finger] Tap the other end of the front.
       *[mouse] Click the other end of the front.
    }
plan-row-far =
    { $pointer ->
        [finger] Tap on the far side of the row.
       *[mouse] Click on the far side of the row.
    }
plan-row-whole = Change the count, or add the row.
plan-row-no-room = There is no room for stalls: place the far side farther off.
plan-area-line =
    { $pointer ->
        [finger] Tap the corners of an area that has no stalls. Stalls in it go.
       *[mouse] Click the corners of an area that has no stalls. Stalls in it go.
    }
plan-zone-line =
    { $pointer ->
        [finger] Tap corners around stalls that are counted together.
       *[mouse] Click corners around stalls that are counted together.
    }
plan-section-line =
    { $pointer ->
        [finger] Tap along a kerb, or around an area: the vehicles in it are counted.
       *[mouse] Click along a kerb, or around an area: the vehicles in it are counted.
    }
plan-chosen =
    { $stalls ->
        [0] No stall is chosen
        [one] { $label } is chosen
       *[other] { $stalls } stalls are chosen
    }
# What is said of the labels of the stalls that are chosen. $guessed: those that no person gave or confirmed
plan-labels-are =
    { $guessed ->
        [0] as painted
       *[other] { $stalls ->
            [one] our guess
           *[other] { $guessed } of { $stalls } labels are our guess
        }
    }
plan-labels = Labels
plan-row-name = Row’s name
plan-rename = Rename
plan-swap = Swap names
plan-swap-two = Swap names: choose stalls of two rows
plan-reverse = Number from the other end
# $by: +1 or −1
plan-shift-by = Numbers { $by }
plan-key-up = Page up
plan-key-down = Page down
plan-row-choice = Row
plan-row-none = None
plan-row-all = All stalls
plan-confirm = Confirm
plan-confirm-all = Confirm all
plan-remove = Remove
plan-kind = Kind
plan-kind-mixed = Several
plan-kind-normal = For everybody
plan-kind-disabled = Disabled persons (D)
plan-kind-charging = Electric (E)
plan-kind-parent = Parents (P)
plan-kind-delivery = Loading (L)
plan-kind-private = Reserved (R)
plan-kind-motorcycle = Motorcycles (M)
plan-kind-staff = Staff (S)
plan-kind-bus = Buses (B)
plan-kind-hgv = Lorries (H)
plan-kind-taxi = Taxis (T)
plan-more = Size, angle, number
plan-width = Width, { $unit }
plan-length = Length, { $unit }
plan-set = Set
plan-set-size = Set the size
plan-turn = Turn by, °
plan-turn-do = Turn
plan-parts = Parts
plan-split = Split
plan-letter = Row letter
plan-first = First number
plan-renumber = Renumber
plan-bad-number = { $field }: give a number.
plan-style = Stalls stand
plan-style-square = square
plan-style-angled = angled
plan-style-parallel = parallel
plan-lean = Lean, °
plan-double = Two rows, back to back
plan-count = Count
plan-count-follows = Count; { $count } by the pitch
plan-add-row = Add row
plan-add-row-of =
    { $stalls ->
        [one] Add 1 stall
       *[other] Add { $stalls } stalls
    }
plan-back = Take back a place
plan-area-name = Name of the area, if any
plan-area-private = Private ground, as a garden: pictures leave it out, nothing is counted there
# Behind the name of such an area
plan-private = private ground
plan-area-add = Add the area
plan-areas = Areas without stalls
plan-area-nameless = Area { $number }
plan-allow = Allow stalls
plan-allow-in = Allow stalls in { $name }
plan-zone-name = Name of the zone
plan-zone-add = Add the zone
plan-zones = Zones
plan-zone-erase-of = Remove the zone { $name }
sections = Sections
section-shape = Shape
section-shape-strip = Strip
section-shape-area = Area
section-side = Side of the line
section-side-right = right
section-side-left = left
section-name = Name of the section
section-kind = Vehicles stand
section-kind-parallel = along the kerb
section-kind-across = across the kerb
section-kind-any = in any direction
section-capacity = Places; empty: by the length
section-note = Note: permit, loading, disabled
section-add = Add the section
section-change = Change
section-change-of = Change the section { $name }
section-remove-of = Remove the section { $name }
section-of = Section { $name }
section-parked = { $parked } of { $capacity } parked
# $words: as section-parked
section-full = { $words }, full
section-over = { $words }, over-full
section-vehicles =
    { $parked ->
        [one] 1 vehicle
       *[other] { $parked } vehicles
    }
section-unseen = not seen
# $words: as section-parked, of the sections that were seen
sections-seen = { $words }, { $seen } of { $sections } sections seen
section-interval = { $least } to { $most }, 9 times in 10.
section-room =
    { $room ->
        [0] No room for another one.
       *[other] Room for { $room } more.
    }
section-capacity-given = { $capacity } places, as a person says
section-capacity-by-length = { $capacity } places by its length
section-no-capacity = nobody says how many places
section-hidden = { $hidden } % is hidden.
section-not-seen = { $unseen } % was not seen.
section-by-stalls = Taken stalls are counted: no vehicles are known.
# Heads of the list of sections
section-head = Section
section-head-parked = Parked
section-head-between = 9 times in 10
section-head-room = Room
section-count = { $parked } ({ $least } to { $most })
section-differs = differs
# $after: as section-parked
section-then = { $before }, then { $after }
section-may-be-same = may be the same
plan-import = Import a plan
plan-import-reads = Reads the file…
plan-import-counts = { $begin } begin, { $stay } change, { $same } are so already, { $end } end.
plan-import-sections = Sections: { $begin } begin, { $stay } change, { $same } are so already, { $end } end.
plan-import-doubt = It is not certain where the plan lies:
# Before a sentence on what the file does not say
plan-import-assumed = Assumed:
plan-import-left =
    { $count ->
        [one] 1 feature is left out
       *[other] { $count } features are left out
    }
plan-import-clashes =
    { $count ->
        [one] 1 label or name is refused: another stall or section keeps it, or the file has it twice
       *[other] { $count } labels or names are refused: other stalls or sections keep them, or the file has them twice
    }
plan-import-number = Put numbers behind them
# $shown: number of lines that are listed
plan-import-which =
    { $shown ->
        [one] Which one, and why
       *[other] Which ones, and why
    }
plan-import-choices = Choices about the file
plan-import-replace = End stalls and sections that the file has not
plan-import-rename = Number labels and names that others keep
plan-import-layer = Layer
plan-import-label = Property with the labels
plan-import-crs = System of coordinates (EPSG:…)
plan-import-units = Units of the drawing
plan-import-point = Point { $number }: x,y,latitude,longitude
plan-import-again = Read it again
plan-import-take = Take the plan
plan-import-take-so = Take it as it lies

## Battery

battery-for-survey = Battery for the survey
battery-charge = Battery { $percent }
battery-home = Home, with reserve
battery-survey = Survey
battery-left = Left
battery-missing = Missing
# The whole bar in words, for screen readers: $parts are the four below.
battery-spoken = Battery { $percent }: { $parts }. { $verdict }.
battery-spoken-home = home with the reserve { $percent }
battery-spoken-survey = survey { $percent }
battery-spoken-left = left { $percent }
battery-spoken-missing = missing { $percent }
battery-not-known = What the survey needs is not known
battery-nothing-left = Nothing is left of the survey
battery-enough-fence = Enough for a lot as large as the fence
battery-enough-found = Enough for the lot found so far
battery-enough-survey = Enough for the rest of the survey
battery-part-fence = Enough for about { $percent } of a lot as large as the fence
battery-part-found = Enough for about { $percent } of the lot found so far
battery-part-survey = Enough for about { $percent } of the rest of the survey
# Spoken aloud.
battery-low = Battery low: { $percent }. It soon returns home.

## The tab of the flight

nothing-known-yet = Nothing known yet.
flight = Flight
health-of-parts = Health of each part
part-link = Autopilot link
part-position = Position
part-ground = On the ground or not
part-home = Home
part-rangefinder = Rangefinder
part-remote-control = Remote control
part-remote-id = Remote ID
part-witness = Second witness
part-vision = Finding stalls
part-mapper = Map
part-planner = Route
part-camera = Camera
part-recording = Recording
part-requests = Requests to the autopilot
part-tasks = Parts of the program
part-loop = Computer
part-working = working
parts-working = all { $parts } working
parts-in-trouble = { $bad } of { $parts } in trouble
fact-autopilot = Autopilot
fact-speed = Speed
fact-from-home = From home
fact-parts = Parts
fact-place = Place
fact-from-armed = From where it was armed
fact-above-ground = Height above ground
fact-climbing = Climbing
fact-wind = Wind
fact-gps = GPS
satellites =
    { $satellites ->
        [one] 1 satellite
       *[other] { $satellites } satellites
    }
fact-voltage = Battery voltage
fact-pictures = Pictures looked through
each-second = { $value } a second
# Titles of plots with their unit.
plot-height = Height, { $unit }
plot-battery = Battery, %
plot-now = now

## Checks before flight

checks = Checks
checks-before-flight = Checks before flight
all-checks = All checks
checks-not-known = not known yet
checks-all-passed = all { $checks } passed
checks-some-passed = { $passed } of { $checks } passed
remedy-failsafes = Set failsafes
remedy-kill = Allow arming again
remedy-fence = Draw the fence
show-checks = Show checks
# Below the button of a remedy, or of Show checks.
remedy-mends =
    { $checks ->
        [one] Mends 1 failed check
       *[other] Mends { $checks } failed checks
    }
remedy-by-hand =
    { $checks ->
        [one] 1 failed: what to do
       *[other] { $checks } failed: what to do
    }

## Heights

heights = Heights
heights-not-known = not known yet
flies-at-height = Flies at { $height }
never-below-or-above = never below { $lowest } or above { $highest }
change-heights = Change heights
heights-unit =
    { $units ->
        [feet] Feet above the place where it was armed.
       *[metres] Metres above the place where it was armed.
    }
save-heights = Save heights
heights-not-stored = Not stored.
lowest-label = Never below (Min)
desired-label = Flies at (Des)
highest-label = Never above (Max)
lowest-no-number =
    { $units ->
        [feet] Never below: give a number of feet above 0.
       *[metres] Never below: give a number of metres above 0.
    }
desired-no-number =
    { $units ->
        [feet] Flies at: give a number of feet above 0.
       *[metres] Flies at: give a number of metres above 0.
    }
highest-no-number =
    { $units ->
        [feet] Never above: give a number of feet above 0.
       *[metres] Never above: give a number of metres above 0.
    }
desired-too-low = Flies at: { $height } is below the lowest height of { $lowest }.
desired-too-high = Flies at: { $height } is above the highest height of { $highest }.
highest-above-fence = Never above: the fence ends at { $ceiling }.

## Fence

fence = Fence
# Parts of the titles of the fence.
corners-and-zones =
    { $corners ->
        [one] 1 corner
       *[other] { $corners } corners
    }{ $zones ->
        [0] { "" }
        [one] , 1 zone
       *[other] , { $zones } zones
    }
fence-of = Fence of { corners-and-zones }
fence-sized = Fence { $extent }, { corners-and-zones }
limits-not-known = not known yet
fence-unusable = The drawn fence cannot be used
fence-drawn-up-to = drawn, up to { $ceiling }
fence-file-up-to = from the settings, up to { $ceiling }
fence-circle = Fence: circle of { $radius }
fence-circle-up-to = around where it is armed, up to { $ceiling }
fence-no-link = No link: it cannot be checked or saved.
fence-cannot-save = This fence cannot be saved
put-right = Put right what is said
being-checked = Being checked
being-checked-line = Being checked.
being-saved = Being saved
nothing-changed = Nothing changed
not-closed-yet = Not closed yet
zone-not-closed-yet = Zone not closed yet
draw-fence = Draw the fence
draw-fence-begin =
    { $pointer ->
        [finger] Tap its corners on the map, one after the other. Or import a file.
       *[mouse] Click its corners on the map, one after the other. Or import a file.
    }
draw-fence-few =
    { $corners ->
        [one] 1 corner set. A fence needs at least 3.
       *[other] { $corners } corners set. A fence needs at least 3.
    }
# $corners is 3 or more.
draw-close =
    { $pointer ->
        [finger] { $corners } corners set. Tap the first one again, or Close.
       *[mouse] { $corners } corners set. Click the first one again, or Close.
    }
draw-zone = Draw a zone that the drone keeps out of
draw-zone-begin =
    { $pointer ->
        [finger] Tap its corners, inside the fence. Add zone again gives it up.
       *[mouse] Click its corners, inside the fence. Add zone again gives it up.
    }
draw-zone-few =
    { $corners ->
        [one] 1 corner set. A zone needs at least 3.
       *[other] { $corners } corners set. A zone needs at least 3.
    }
remove-corners-line =
    { $pointer ->
        [finger] Tap the corners that are to go.
       *[mouse] Click the corners that are to go.
    }
remove-zones-line =
    { $pointer ->
        [finger] Tap the corners that are to go, or into a zone to remove it.
       *[mouse] Click the corners that are to go, or into a zone to remove it.
    }
stays-inside = The drone stays { $margin } inside it, at the dotted line, and below { $height }.
edit-the-fence = Edit the fence
edit-fence = Edit fence
save-fence = Save fence
ceiling = Ceiling
ceiling-label =
    { $units ->
        [feet] Ceiling, feet above where it is armed
       *[metres] Ceiling, metres above where it is armed
    }
ceiling-no-number = Ceiling: give a number above 0.
set-aside = Set aside
set-aside-label = Set aside the drawn fence
set-aside-what = Set the drawn fence aside
fence-saved = The fence is saved. The next Arm uploads it.
fence-not-saved = The fence was not saved.
fence-not-checked = It could not be checked.
fence-on-ground-only = The fence is changed on the ground only, with the motors off.
drawing-kept = What was drawn is kept.

## Tools while a fence or an outline is drawn, short

fence-tools = Fence tools
outline-tools = Outline tools
fence-file = Fence file
outline-file = Outline file
tool-remove = Remove
tool-remove-aloud = Remove corners
close-ring = Close the ring
tool-square = Square
tool-undo = Undo
tool-zone = Add zone
tool-zone-aloud = Add zone: an exclusion zone
tool-hole = Add hole
tool-hole-aloud = Add hole: a part that is not explored
tool-clear = Clear
tool-import = Import
tool-export = Export
file-unanswered = The drone did not answer: the file could not be read.
file-too-large = The file is too large for an area.

# What is wrong with a file. $kind: what it should hold. $ring, $corner: their numbers.
file-one-polygon =
    { $kind ->
        [fence] The file must hold exactly one polygon. Save the fence alone, as GeoJSON.
       *[outline] The file must hold exactly one polygon. Save the outline alone, as GeoJSON.
    }
file-not-geojson =
    { $kind ->
        [fence] The file is not GeoJSON. Save the fence as GeoJSON.
       *[outline] The file is not GeoJSON. Save the outline as GeoJSON.
    }
file-zone-holes = An exclusion zone must be one ring without holes.
file-no-ring = The polygon has no ring of corners.
file-polygon-few = The polygon has { $corners } corners. It needs at least 3.
file-zone-few = Zone { $zone } has { $corners } corners. It needs at least 3.
file-polygon-no-place = The polygon: corner { $corner } is no place on Earth. Longitude comes before latitude, in degrees (WGS-84).
file-zone-no-place = Zone { $zone }: corner { $corner } is no place on Earth. Longitude comes before latitude, in degrees (WGS-84).

## The area to explore

outline-on-ground-only = On the ground only, with the motors off
outline-several = It has several polygons: remove it first
area-to-explore = Area to explore
explores-found-lot = Explores the lot that it finds
no-outline = no outline is set
explores-outline = Explores an outline of { $area }
polygons-and-holes =
    { $polygons ->
        [one] 1 polygon
       *[other] { $polygons } polygons
    }{ $holes ->
        [0] { "" }
        [one] , 1 hole
       *[other] , { $holes } holes
    }
outline-from-file = { polygons-and-holes }, from the settings
outline-set = { polygons-and-holes }, set for this survey
corners-and-holes =
    { $corners ->
        [one] 1 corner
       *[other] { $corners } corners
    }{ $holes ->
        [0] { "" }
        [one] , 1 hole
       *[other] , { $holes } holes
    }
outline-sized = Outline of { $area }, { corners-and-holes }
outline-of = Outline, { corners-and-holes }
draw-area = Draw the area to explore
draw-hole = Draw a part that is not explored
draw-area-begin =
    { $pointer ->
        [finger] Tap its corners on the map, one after the other. Or import a file.
       *[mouse] Click its corners on the map, one after the other. Or import a file.
    }
draw-hole-begin =
    { $pointer ->
        [finger] Tap its corners on the map, one after the other. Add hole again gives it up.
       *[mouse] Click its corners on the map, one after the other. Add hole again gives it up.
    }
draw-ring-few =
    { $corners ->
        [one] 1 corner set. It needs at least 3.
       *[other] { $corners } corners set. It needs at least 3.
    }
outline-no-link = No link: it cannot be set.
outline-cannot-set = This outline cannot be set
outline-crosses = Two of its sides cross: move a corner.
being-set = Being set
outline-meaning = The next Explore sees all of it inside the fence, and nothing else.
set-outline = Set outline
edit-outline = Edit outline
draw-outline = Draw outline
last-outline = Last outline
last-outline-label = Last outline: take it again
remove = Remove
remove-outline = Remove the outline
set-outline-what = Set the outline
outline-is-set = The outline is set. The next Explore sees all of it inside the fence.
outline-is-removed = The outline is removed. The next Explore finds the lot by looking.
outline-paused = The area to explore is drawn on the ground only, with the motors off.

## Map

map = Map
map-of-lot = Map of the lot
zoom-in = Zoom in
zoom-out = Zoom out
follow-drone = Follow the drone
whole-lot = Whole lot
turn-with-drone = Turn the map with the drone
drone-up = The drone's nose is up. Press for north up
north-up = North is up. Press to turn the map with the drone
north-on-map = North on the map
# North, one letter.
north-letter = N
layers = Layers
shown-on-map = Shown on the map
layer-stalls = Stalls
layer-picture = Picture of the ground
layer-fence = Fence and zones
layer-outline = Area to explore
layer-trail = Where it flew
layer-background = Background
last-seen-here = Last seen here { $age } ago
ring-of-reach = The ring: as far as it can be by now
no-map-yet = No map yet
map-fills = It fills as the drone flies. The dotted line is the fence: the drone stays inside.
map-begins = It begins where the drone is armed, and fills as it flies.

## Measuring on the map

measure = Measure
measure-begin =
    { $pointer ->
        [finger] Tap two or more places.
       *[mouse] Click two or more places.
    }
measure-next =
    { $pointer ->
        [finger] Tap the next place.
       *[mouse] Click the next place.
    }
measure-go-on =
    { $pointer ->
        [finger] Tap more places to go on.
       *[mouse] Click more places to go on.
    }
measure-close =
    { $pointer ->
        [finger] Tap the first place to close it and see the area.
       *[mouse] Click the first place to close it and see the area.
    }
measure-again =
    { $pointer ->
        [finger] Tap to begin again.
       *[mouse] Click to begin again.
    }
measure-around = { $length } around
measure-area-around = { $area }, { $length } around
measure-crosses = Its sides cross: it has no one area.
measure-back = Take the last place back
measure-stop = Stop measuring

## Live picture

live-video = Live video
camera-picture = Camera picture, straight down, stalls outlined
live-picture = Live picture
swap-map-video = Swap map and video
full-screen = Full screen
save-picture = Save this picture
small-window = Show in a small window
close-small-window = Close the small window
north-in-picture = North in the picture
live-age = Live, { $age }
simulation-age = Simulation, { $age }
simulation-age-old = Simulation, { $age } old
frozen = Frozen
simulation-frozen = Simulation, frozen
no-picture-yet = No picture yet
picture-is-old = Picture is { $age } old
no-new-picture = No new picture arrives
waiting-for-camera = Waiting for the camera

## Messages

messages = Messages
nothing-happened = Nothing happened yet.
no-message-like-this = No message is like this.
messages-filtered = { $found } of { $all } messages shown
show-all-messages = Show all
search-messages = Search messages
warnings = Warnings
save = Save
details = Details
link-lost-note = Link lost.
link-back-note = Link is back.
# $what: what was asked of the drone. $reason: why it was refused, mostly the drone's own words.
refused = { $what }: { $reason }
no-reason = no reason given
not-sent = No link to the drone. Nothing was sent.
no-answer = No answer. It is not known whether the drone took it.
link-lost-before-answer = The link was lost. It is not known whether the drone took it.
log-out-unanswered = Log out: the drone did not answer. Try again.

## Settings

about-flight = About the flight
settings = Settings
appearance = Appearance
theme-auto = As this device
theme-light = Light
theme-dark = Dark
theme-outdoor = Outdoors
units = Units
units-metres = Metres
units-feet = Feet
units-note = The drone's own messages stay in metres.
language = Language
language-auto = As this browser
language-note = What the autopilot says stays in English.
left-handed = Left-handed
left-handed-note = Hold and Land in the lower left corner
sound = Sound
sound-note = Tone and voice: lost link, low battery, and others who act
logged-in-viewer = Logged in as viewer
logged-in-operator = Logged in as operator
on-this-browser = On this browser
log-out = Log out
version = Parking Lot Hawk { $version }
licences = Licences
documentation = Documentation
documentation-of = Documentation of Parking Lot Hawk { $version }
your-name = Your name
name-question = What is your name?
others-read = The others read: { $name }
others-read-it = The others read it beside what you do
all-settings = All settings of the drone's program
settings-unanswered = The drone does not answer. Close this and open it again.
settings-asking = Asking the drone
settings-note = They are read when the program starts: from config.toml, or HAWK_SECTION__KEY in its environment.
search-settings = Search settings
no-setting-like-this = No setting is like this.
setting-changed = changed
setting-not-set = not set
setting-none = none
setting-bounds = { $lowest } to { $highest }

## Keys

keys = Keys
all-keys = All keys
keys-note = Off while you type.
key-hold = Hold: stop and stay, at once
key-move = Move: then click the map
key-resume = Resume after a pilot flew
key-swap = Video large, map small, and back
key-survey = Show the survey
key-keys = Show these keys
key-escape = Leave what is asked
key-tab = To the next button
key-enter = Press it; kept pressed on a slide: slide it
# Names of keys, as they stand on a keyboard.
escape-key = Esc
tab-key = Tab
enter-key = Enter

## Lots over time: the views that are read when one is opened

archive-title = Lots over time
at-a-glance = The drone at a glance
views = Views
view-fly = Fly
view-lots = Lots
view-compare = Compare
view-report = Report
view-recordings = Recordings
title-view = { $view } · { $lot }
no-drone = No drone
time-bar = Surveys by day and hour
time-bar-before = Earlier days
time-bar-after = Later days
time-bar-span = Days that the bar shows
time-bar-day = Day
time-bar-week = Week
time-bar-month = Month
time-bar-few = 3 days
time-bar-play = Play the flight
time-bar-today = { $day }, today
time-bar-nobody = nobody flew
time-bar-open-day = From { $time }: { $count } surveys. Open the day
time-bar-deleted = { $time } deleted
time-bar-bring-back = Bring back
time-bar-due-in =
    { $hours ->
        [0] due in { $minutes } min
       *[other] due in { $hours } h { $minutes } min
    }
time-bar-due = due at { $time }
time-bar-due-since = due since { $time }
time-bar-not-counted = no figure uses it
time-bar-more =
    { $count ->
        [one] and one more
       *[other] and { $count } more
    }
changes = Changes
change-delete = Survey deleted
change-merge = Another lot merged into this one
change-move = Survey moved
change-name = Lot named
change-place = Place of a survey chosen
change-plan = Plan corrected
change-split = Lot split
change-time-zone = Time zone chosen
change-take-over = Changes taken over into the plan
change-drop = Proposals dropped
change-pin = Lot pinned to its place
change-import = Plan imported
change-undone = undone
change-undo = Undo: { $change }, { $when }
archive-delete-survey-surely = Delete this survey
archive-list = List of surveys
edit-plan = Edit plan
share-lot = Share
export-survey = Export
# The flight's own map shows other stalls than the lot's plan has.
survey-found = The flight itself found { $found } stalls. Counts are of the { $stalls } of the lot's plan.
archive-free-of = free of { $stalls } stalls
archive-no-picture = The picture of this survey is not kept.
archive-row = Row
archive-view-parts = Parts of this view
archive-ask-again = Ask again
archive-lot = Lot
archive-from = From
archive-to = To
archive-surveys = Surveys
archive-stalls = Stalls
archive-links = Links
archive-unanswered = No answer: look at the connection. The page asks again by itself.
# $status: number of HTTP
archive-refused = The drone refused that (HTTP { $status }). Load the page again.
archive-asking = Asking the drone
archive-no-lot = No lot is stored yet: fly a first survey.
archive-no-survey = This lot has no survey: fly one, or count it from photographs.
archive-two-needed = Two surveys that count are needed: fly again.
archive-none-counts = No survey of this period counts: choose other days, or give a survey its place in Fly.
archive-program = Program { $program }
survey-gone = The survey of this address is not there: it was deleted, or moved. The newest one is shown.
lot-gone = The lot of this address is not there: it was merged, or erased. Another one is shown.
archive-when = When
archive-free = Free
archive-taken = Taken
archive-unknown = Unclear
archive-occupancy = Occupancy
archive-note = Note
archive-counts = { $free } free, { $taken } taken, { $unknown } unclear
archive-survey-of = Survey of { $when }
archive-files = Files
archive-delete-survey = Delete survey
archive-survey-deleted = The survey of { $when } is deleted.
archive-undo = Undo
archive-simulated = Simulated
archive-blurred = Seen only blurred: { $blurred } of { $stalls } stalls
archive-of-photographs = From photographs ({ $name })
archive-of-orthophoto = From an orthophoto ({ $name })
archive-of-film = From a film ({ $name })
archive-limit-by-gps = Its pictures lie where their files say: stalls may be metres off
archive-limit-stretched = Its map may be turned or stretched: stalls at its ends may be metres off
archive-limit-coarse = Its pictures are coarse: fewer stalls are found
archive-limit-partly = A part of the lot was not seen
archive-long = It lasted { $minutes } min: cars came and went meanwhile
archive-why-unregistered = Its place on the lot is not certain
archive-why-time = Its time is not certain
archive-why-looks = It looked at no stall of the lot
archive-left-out = No figure uses this survey. { $why }.
archive-left-out-count =
    { $surveys ->
        [one] { $surveys } survey of this period is left out: its place or time is not certain.
       *[other] { $surveys } surveys of this period are left out: their place or time is not certain.
    }
# A share with the ends of its interval, in percent.
archive-share = { $value } % ({ $low } to { $high } %)
archive-before = Before
archive-after = After
archive-changes = Changed stalls
compare-day-time = { $day }, { $time }
compare-modes = How both are compared
compare-swipe = Swipe
compare-fade = Fade
compare-side = Side by side
compare-swipe-handle = Line between both surveys
compare-fade-handle = How much of the later survey is shown
compare-swipe-at = { $share } % of the map shows { $after }, the rest { $before }
compare-fade-at = { $after } shown by { $share } %, over { $before }
compare-free-of = { $free } free of { $stalls }
compare-not-there = Not in this survey's plan
compare-ends = Surveys that are compared
compare-end-before = before
compare-end-after = after
compare-choose = A press on the bar below chooses: { $end }.
compare-end-gone = The survey { $end } of this address is not there: it was deleted, or moved. The newest one is shown.
compare-none-seen = Nothing to compare
compare-as-many = As many free as before
compare-more = { $count } more free
compare-fewer = { $count } fewer free
compare-of = of the { $stalls } seen in both
compare-interval-more = { $low } to { $high } more, { $times } times in 10.
compare-interval-fewer = { $low } to { $high } fewer, { $times } times in 10.
compare-interval-both = { $fewer } fewer to { $more } more, { $times } times in 10.
compare-became = { $taken } became taken, { $free } became free, { $unknown } became unclear.
compare-unclear =
    { $count ->
        [one] { $count } stall is unclear in one of them: not counted.
       *[other] { $count } stalls are unclear in one of them: not counted.
    }
compare-new =
    { $count ->
        [one] { $labels } is new since: not compared.
       *[other] { $rest ->
            [0] { $labels } are new since: not compared.
           *[other] { $labels } and { $rest } others are new since: not compared.
        }
    }
compare-gone =
    { $count ->
        [one] { $labels } is gone since: not compared.
       *[other] { $rest ->
            [0] { $labels } are gone since: not compared.
           *[other] { $labels } and { $rest } others are gone since: not compared.
        }
    }
compare-redrawn =
    { $count ->
        [one] { $count } stall was drawn again in the plan: compared by its ground.
       *[other] { $count } stalls were drawn again in the plan: compared by their ground.
    }
compare-row =
    { $count ->
        [one] Row { $row }, { $count } change
       *[other] Row { $row }, { $count } changes
    }
compare-row-none =
    { $count ->
        [one] Other stalls, { $count } change
       *[other] Other stalls, { $count } changes
    }
compare-nothing = No stall changed its state.
compare-states = { $before }, now { $after }
archive-stall = Stall
archive-by-row = Rows
archive-by-zone = Zones
archive-by-kind = Kinds
archive-by-section = Sections
archive-heat = Share of surveys that found each stall taken
archive-heat-note =
    { $surveys ->
        [one] Share of { $surveys } survey that found each stall taken.
       *[other] Share of { $surveys } surveys that found each stall taken. Choose a stall to see its last looks.
    }
archive-stall-of = Stall { $label }
archive-stall-share =
    { $surveys ->
        [one] Share of the { $surveys } survey that saw it in which it was taken:
       *[other] Share of the { $surveys } surveys that saw it in which it was taken:
    }
archive-state-free = free
archive-state-taken = taken
archive-state-unknown = unclear
archive-no-zone = In no zone
archive-chance-taken = probability of taken { $value } %
archive-unseen = Not seen
ask-question = How full is { $part } on { $days } { $hours ->
        [all] at
       *[some] between
    } { $clock } { $period ->
        [all] over
        [month] in
       *[days] from
    } { $when }?
ask-question-part = The question
ask-part = Part of the lot
ask-days = Days of the week
ask-hours = Hours of the day
ask-period = Period
ask-whole-lot = the whole lot
ask-rows =
    { $count ->
        [one] Row { $names }
       *[other] Rows { $names }
    }
ask-every-day = every day
ask-every-hour = any hour
ask-every-survey = all surveys
ask-run = { $first }–{ $last }
ask-hours-run = { $first }–{ $last }
ask-hour = { $hour }:00
ask-since = { $day } on
ask-until = the first survey to { $day }
ask-dates = { $first } to { $last }
ask-month-surveys =
    { $surveys ->
        [one] { $month }, { $surveys } survey
       *[other] { $month }, { $surveys } surveys
    }
ask-taken = { $value } % taken
ask-low-high = { $low } to { $high } %
ask-stalls =
    { $exact ->
        [yes] { $low } of { $stalls } stalls are taken on average.
       *[no] { $low } to { $high } of { $stalls } stalls are taken on average.
    }
ask-ends = Fullest on { $fullDay }s at { $fullHour } ({ $full }), emptiest on { $emptyDay }s at { $emptyHour } ({ $empty }).
ask-behind = From { $surveys ->
        [one] { $surveys } survey
       *[other] { $surveys } surveys
    } on { $days ->
        [one] { $days } day
       *[other] { $days } days
    }, { $dates }, { $clock }.
ask-nobody-at = Nobody flew at { $hours }.
ask-none = Nobody flew then.
ask-none-counts = No survey of then counts.
ask-none-remedy = Choose other hours, other days or a longer period.
ask-heat = { $part } by weekday and hour, { $when }
ask-heat-keys = Arrow keys go over the hours, Shift and arrows choose several, Enter asks.
ask-range = { $low } to { $high }
ask-places = { $value } vehicles ({ $low } to { $high }) are parked on { $places } places on average.
ask-vehicles = { $value } vehicles ({ $low } to { $high }) are parked on average. Nobody said how many places there are.
ask-vehicles-large = { $value } vehicles
ask-head-vehicles = Vehicles
ask-scale-vehicles = 0 to { $most } vehicles
ask-scale = 0 to 100 % taken
ask-nobody = nobody flew
ask-asked = asked
ask-whole-week = The whole week
ask-all-hours = 24 hours
ask-flown-hours = Flown hours
ask-hour-from = { $first }:00–{ $last }:00
ask-cell = { $day } { $hours }: { $what }
ask-cell-flown =
    { $surveys ->
        [one] { $value }, { $surveys } survey, { $range }
       *[other] { $value }, { $surveys } surveys, { $range }
    }
ask-surveys =
    { $surveys ->
        [one] { $surveys } survey
       *[other] { $surveys } surveys
    }
ask-figures = The figures behind it
ask-times = { $times } times in 10
ask-all = All, each survey once
ask-elsewhere = The same, elsewhere
ask-other-rows = Other rows, same hours:
ask-command = In a terminal
ask-copy-command = Copy the line
ask-copy-address = Copy the address of this question
ask-copied = Copied: { $text }
ask-copy-by-hand = This browser does not let the page copy. Copy it by hand: { $text }
ask-document = The report: print it or download it
ask-done = Done
document-title = The report of what is asked
document-paper = Paper
document-pdf = PDF
document-xlsx = Workbook
document-writing = { $kind }: the drone writes it
document-saved = { $name } is saved, { $size }.
document-refused = { $kind }: { $why }
document-print-instead = Print it by the browser instead.
archive-print = Print
archive-no-recording = There is no recording here.
archive-recordings-size =
    { $count ->
        [one] { $count } recording, { $size }
       *[other] { $count } recordings, { $size }
    }
archive-length = Length
archive-size = Size
archive-keep = Keep
archive-keep-of = Keep the recording of { $when }
archive-file = File
archive-under-way = Under way
archive-download = Download
archive-download-of = Download the recording of { $when }
archive-delete = Delete
archive-delete-of = Delete the recording of { $when }
archive-delete-surely = Delete for good
archive-delete-surely-of = Delete the recording of { $when } for good
archive-links-note = A link shows this lot to everyone who has it, without a login: every survey, those to come too, with counts, stalls, figures and report. It shows no recording, no operator and no other lot, and changes nothing. It ends by itself, and can be taken back.
archive-link-days = Days
archive-make-link = Make a link
archive-link = Link
archive-link-made = This link is shown once. It ends on { $ends }.
archive-link-open = Made { $made }, ends { $ends }
archive-link-shut = Made { $made }, shut
archive-take-back = Take back

asked-recordings-ask = Ask for the recording
asked-recordings-take-back = Ask no more
# $drone: name of the drone that flew the survey
asked-recordings-asked = { $drone } is asked for the recording. It sends it from the ground.
# $received, $size: sizes as 3.2 MB
asked-recordings-coming = { $received } of { $size } of the recording are here. { $drone } sends it from the ground.
asked-recordings-never = { $drone } gives no recordings: its settings forbid it (collect.recordings).
asked-recordings-gone = { $drone } has no recording of this survey.

## A recorded flight

film = Film of the flight
film-not-live = Recording, not live
film-all = All recordings
film-watch = Watch the flight of { $when }
film-reading = The recording is being read …
film-damage = The recording is damaged after { $span }:
film-play = Play
film-pause = Pause
film-time = Time
film-speed = Speed
film-phases = What the drone did
film-week = Back to week
film-before = The recording before
film-after = The recording after
film-now = { $clock }, { $span }
film-recorded = Recorded, { $clock }
film-no-picture = No picture yet
film-no-map = The recording has no map
film-map = Map of the recording: { $stalls }
film-seen = { $seen ->
        [one] { $seen } stall seen at this moment
       *[other] { $seen } stalls seen at this moment
    }
film-seen-of = { $seen } of { $all } stalls seen at this moment
film-values = Battery, height, and distance from home
film-left = { $time } until it must return
film-from-home = from home
film-kept = kept
film-kept-until = kept until { $day }
film-pale = Pale: not seen yet

keep-it = Keep it
film-gone = This recording is not there any more: it was deleted.
ask-part-gone = The lot has no row, zone or kind of this name: it may be called otherwise now.
address-unread = The address names what is no place of this page, and it is left out: { $parts }
compare-same = The address names the same survey twice: choose another one in Lots.
desk-silent-title = No answer from the desk for { $age }
desk-silent-text = What is shown may be old. The page connects again by itself.
explore-again-question =
    { $lots ->
        [one] Survey the lot again?
       *[other] Survey { $lots } lots again?
    }
explore-again-meaning = { $distance } over every stall that is known, inside the fence. Hold stops it.

# Lots: all of them on one map and in one table.
all-lots = All lots
all-lots-map =
    { $lots ->
        [one] Map of 1 lot
       *[other] Map of { $lots } lots
    }
all-lots-whole = Show all lots
all-lots-search = Search
all-lots-order = Order
all-lots-by-name = By name
all-lots-by-free = Fullest first
all-lots-by-seen = Longest not seen first
all-lots-in-sight = Only lots on the map
all-lots-report =
    { $lots ->
        [one] Report of 1 lot
       *[other] Report of { $lots } lots
    }
all-lots-report-most = A report has { $lots } lots at most: search for fewer.
all-lots-found = { $lots } of { $all } lots
all-lots-more = Show { $lots } more
all-lots-stalls = Stalls
all-lots-surveys = Surveys
all-lots-seen = Last seen
all-lots-by-due = Due first
all-lots-by-drone = By drone
all-lots-drone = Drone
all-lots-due = Survey due
all-lots-due-since = since { $when }
all-lots-never = never
all-lots-free = { $free } free

# Arrivals: what drones and programs have sent to a desk, and what became of it.
arrivals = Arrivals
arrivals-none = Nothing of this kind has come.
arrivals-more = Show more
arrivals-sender = From
arrivals-outcome = Outcome
arrivals-what = What
arrivals-all = All
arrivals-unknown = unknown sender
arrivals-taken = Taken
arrivals-known = Known already
arrivals-older = Older than what is here
arrivals-waits = Plan waits for you
arrivals-refused = Refused
# $times: number of refusals in a row
arrivals-times = × { $times }
arrivals-kind-survey = Survey
arrivals-kind-lot = Lot
arrivals-kind-file = File
arrivals-kind-recording = Recording
arrivals-kind-other = Request
