# A report of a lot's use, on paper. What stands behind $ is a number, a date or a name in the report's own language.

kind-of-document = Parking survey report
author = Parking Lot Hawk, { $program }
times = Times are those of { $zone }.
made = Made { $at }.
period = { $first } to { $last }
page = Page
page-of = of

asked-heading = What was asked:
asked = how many stalls { $part } are taken, { $days }, { $hours }.
part-lot = of the lot
part-rows = { $count ->
    [one] of row { $names }
   *[other] of rows { $names }
}
part-zones = { $count ->
    [one] of zone { $names }
   *[other] of zones { $names }
}
part-kinds = of the kind { $names }
any-day = on any day
days = { $runs }
days-run = { $first } to { $last }
any-hour = at any hour
hours = { $runs }
hours-run = from { $first } to { $last }
no-answer = No survey of this period counts: nobody flew then, or every survey was left out.
surveyed = { $surveys ->
    [one] One survey on one day
   *[other] { $surveys } surveys on { $days ->
        [one] one day
       *[other] { $days } days
    }
} looked at { $stalls ->
    [one] its one stall
   *[other] its { $stalls } stalls
}.
answer = On average { $share } were taken
answer-range = ({ $range }): { $amount } of { $stalls } stalls ({ $amounts }).
simulated = { $count ->
    [one] One survey was flown by a simulator: its cars are drawn, not real.
   *[other] { $count } surveys were flown by a simulator: their cars are drawn, not real.
}

range = { $low } to { $high }
free = free
taken = taken
unclear = unclear
free-stalls = free
free-estimated = free, estimated
taken-stalls = taken
unclear-stalls = unclear
north = N
metres = { $metres } m
picture = The lot from above, with its stalls
newest = Newest survey, { $at }: { $free } free, { $taken } taken, { $unclear } unclear; { $share } taken ({ $range }).
labels-painted = Letters and numbers are as painted.
labels-guessed = Letters and numbers are our guess.
labels-both = { $named } of { $stalls } labels are as painted, the others are our guess.
zones-dotted = Dotted: zones.
picture-broken = The picture of this survey is damaged, and left out.
nothing-to-draw = There is neither a picture nor a stall to draw.
by-link = The ground is not shown by a link.
not-kept = The picture of this survey is not kept any more.

in-short = In short
mean = taken, mean of { $hours ->
    [one] one surveyed hour
   *[other] { $hours } surveyed hours
}
fullest = fullest: { $at }
emptiest = emptiest: { $at }
only = only survey: { $at }
fullest-row = fullest row, { $share } taken
fullest-row-name = Row { $row }
stalls-taken = stalls taken on average, of { $stalls }

curve = Taken, %, by survey
curve-words = Share of taken stalls at each survey
rows = Rows
rows-asked = Rows, at the hours asked
row = Row
stalls = stalls
always = always
always-words = Always: stalls that every survey of the period found taken.
lot = Lot
asked-part = Asked
name = Name
range-head = 9 in 10

ranges-hold = Ranges hold the true figure 9 times in 10.
hatched = Hatched: nobody flew.
rivals = { $count ->
    [one] One other survey may have been as full as the fullest.
   *[other] { $count } other surveys may have been as full as the fullest.
}
between = Hours between surveys were not seen.
left-out-of = { $count ->
    [one] One survey is left out; the list of surveys says why.
   *[other] { $count } surveys are left out; the list of surveys says why.
}
nobody-identified = No car or person was identified.
unreadable = { $count ->
    [one] One survey or version of the layout is damaged on the disk, and is in no list here.
   *[other] { $count } surveys or versions of the layout are damaged on the disk, and are in no list here.
}

heat-map = Weekday by hour
heat-map-words = Mean share of taken stalls in each hour of the week, with its range. Empty: nobody flew. Framed: asked.
heat-map-all = Mean share of taken stalls in each hour of the week, with its range. Empty: nobody flew.
hour = Hour
zones = Zones
zone = Zone
no-zone = no zone
other-row = other
kinds = Kinds of stalls
stall-kind = Kind
kind = { $kind ->
    [disabled] disabled persons
    [charging] electric vehicles
    [parent] parents with children
    [delivery] loading
    [private] reserved
    [motorcycle] motorcycles
    [staff] staff
    [bus] buses
    [hgv] lorries
    [taxi] taxis
   *[normal] normal
}

surveys = Surveys
survey = Survey
by-pictures = by pictures of others
by-simulator = simulated
surveys-cut = The newest { $shown } of { $count } surveys. The workbook lists all.
rows-cut = The first { $shown } of { $count }. The workbook lists all.
left-out = Left out
why = Why
why-deleted = deleted by a person
why-unregistered = it is not certain where it lies on the lot
why-no_time = its time is not sure
why-no_looks = it looked at no stall of the lot
why-unseen = it saw no stall of what is asked
layouts = Changes of the layout
since = Since
layout-first = found by the first survey
layout-corrected = corrected by hand
layout-taken = taken over from a survey

method = Method and limits
method-look = A survey looks at every stall from above. A program decides of each stall whether it is free or taken, with a probability; where it cannot, the stall is unclear and counts as neither.
method-range = A range holds the true figure 9 times in 10. It has room for wrong states, for stalls that were not seen, and for what changed within the hour of a survey.
method-mean = A mean is over the hours with a survey, which count alike. An hour that nobody flew is in no figure; it is not zero.
method-between = A survey shows a moment. Nothing is known of the time between two surveys: a stall that was free in both may have been taken between them.
method-always = A stall counts as always taken where two surveys or more saw it, and each found it taken.
method-labels = Labels are as painted where a person confirmed them, else our guess. They are those of the present plan, for older surveys too.
method-pictures = { $count ->
    [one] One survey was made of pictures that others took: its places and its time are theirs.
   *[other] { $count } surveys were made of pictures that others took: their places and times are theirs.
}
method-private = No number plate is read, and no car or person is identified or followed.

summary = Summary
what = What
value = Value
low = Low
high = High
count-surveys = Surveys
unit = Unit
weekday = Weekday
is-asked = Asked
days-head = Days
label = Label
id = Id
share-taken = Taken
surveys-seen = Surveys with a state
began = Began
ended = Ended
clock = Time zone
first-day = First day
last-day = Last day
made-at = Made
question = Question
unit-share = share of stalls
unit-stalls = stalls
state = { $state ->
    [free] free
    [taken] taken
    [unseen] unclear
   *[none] {""}
}
mean-share = Taken, mean of the surveyed hours
mean-stalls = Stalls taken, mean of the surveyed hours
hours-surveyed = Surveyed hours
fullest-survey = Fullest survey
emptiest-survey = Emptiest survey
yes = yes
states-cut = States of the newest { $shown } of { $count } surveys.

# -- sections: vehicles that were counted

sections = Sections
sections-words = Vehicles that the survey of { $at } counted. Sections count vehicles, of the places that they have; all other figures count stalls.
section = Section
vehicles = Vehicles
section-places = Places
section-occupancy = Of the places
section-room = Room for
section-hidden = Hidden, not seen
section-given = Places by a person
section-note = Note
sections-hours = Sections, weekday by hour: { $names }
sections-hours-places = Mean number of vehicles in each hour of the week, as a share of { $places } places, with its range. Empty: nobody flew.
sections-hours-alone = Mean number of vehicles in each hour of the week, with its range. Empty: nobody flew. Nobody said how many places there are.

# -- several lots: the first page

lots = { $count ->
    [one] One lot
   *[other] { $count } lots
}
lots-head = Lots
part-lots = of each lot
times-of-each = Times are those of each lot.
lots-newest = The table has the newest survey of each lot; its own pages have the answer.
newest-survey = Newest survey
no-survey = no survey that counts
drone = Drone
due = Survey due
due-since = since { $when }
total = Total
lots-together = How the errors of lots go together is not measured: the range of the total adds the ends of all ranges, as if all lots erred alike.
lots-apart = If each lot erred for itself, { $range } stalls would be free.
lots-apart-vehicles = If each lot erred for itself, there would be { $range } vehicles in sections.
lots-unseen = Free, estimated: of all stalls. Those that a survey did not see are taken to be as full as the others.
lots-moments = The total is of no single moment: the surveys are from { $first } to { $last }.
lots-uncounted = { $count ->
    [one] One lot has no survey that counts, and is in no total.
   *[other] { $count } lots have no survey that counts, and are in no total.
}
sections-unseen = { $count ->
    [one] one section not seen
   *[other] { $count } sections not seen
}
total-alike = Total, as if all lots erred alike
total-apart = Total, as if each lot erred for itself
number = Number
age-days = Age, days
