### Les mots de la page en français. La syntaxe et la liste des messages sont celles de en.ftl.
###
### Espaces et apostrophes : on tape l'espace ordinaire avant ; : ! ? % et l'apostrophe droite, la page met les espaces
### insécables et l'apostrophe courbe. Entre un nombre et son unité, { "\u00A0" } est l'espace insécable.
###
### Glossaire
###   arm / disarm        armer / désarmer
###   take off, land      décoller (décollage), atterrir (atterrissage)
###   hold                vol stationnaire, « Stationnaire »
###   home, return home   point de départ, retour au départ
###   explore, survey     explorer (exploration), relevé
###   resume              reprendre (après un vol à la radiocommande)
###   cut the motors      couper les moteurs
###   control             les commandes : avoir, demander, prendre, donner ; sur un bouton court, rendre la main
###   operator, viewer    opérateur, observateur
###   lot, stall          parking, place (libre, occupée, incertaine)
###   fence, zone         géobarrière, zone d'exclusion
###   ceiling, outline    plafond, contour (de l'aire à explorer)
###   check               contrôle (avant vol)
###   link, autopilot     liaison, autopilote
###   place on the map    point, endroit (« place » est réservé au stationnement)

## Nombres et unités

length =
    { $units ->
        [feet] { $value }{ "\u00A0" }ft
       *[metres] { $value }{ "\u00A0" }m
    }
length-km = { $value }{ "\u00A0" }km
speed =
    { $units ->
        [feet] { $value }{ "\u00A0" }mph
       *[metres] { $value }{ "\u00A0" }m/s
    }
area =
    { $units ->
        [feet] { $value }{ "\u00A0" }ft²
       *[metres] { $value }{ "\u00A0" }m²
    }
large-area =
    { $units ->
        [feet] { $value }{ "\u00A0" }acres
       *[metres] { $value }{ "\u00A0" }ha
    }
extent = { $one }{ "\u00A0" }×{ "\u00A0" }{ $other }
seconds = { $value }{ "\u00A0" }s
minutes = { $value }{ "\u00A0" }min
minutes-seconds = { $minutes }{ "\u00A0" }min { $seconds }{ "\u00A0" }s
percent = { $value } %
volts = { $value }{ "\u00A0" }V
file-size =
    { $unit ->
        [B] { $value }{ "\u00A0" }o
        [kB] { $value }{ "\u00A0" }ko
        [MB] { $value }{ "\u00A0" }Mo
       *[GB] { $value }{ "\u00A0" }Go
    }
latitude =
    { $side ->
        [north] { $degrees }°{ "\u00A0" }N
       *[south] { $degrees }°{ "\u00A0" }S
    }
longitude =
    { $side ->
        [east] { $degrees }°{ "\u00A0" }E
       *[west] { $degrees }°{ "\u00A0" }O
    }
place = { $latitude } ; { $longitude }
offset-east =
    { $side ->
        [east] { $length }{ "\u00A0" }E
       *[west] { $length }{ "\u00A0" }O
    }
offset-north =
    { $side ->
        [north] { $length }{ "\u00A0" }N
       *[south] { $length }{ "\u00A0" }S
    }
offset = { $east }, { $north }
wind =
    { $from ->
        [north] { $speed } du nord
        [north-east] { $speed } du nord-est
        [east] { $speed } de l'est
        [south-east] { $speed } du sud-est
        [south] { $speed } du sud
        [south-west] { $speed } du sud-ouest
        [west] { $speed } de l'ouest
       *[north-west] { $speed } du nord-ouest
    }
age = il y a { $age }

## Actions de la barre

arm = Armer
arm-note = Démarre les moteurs
checks-passed =
    { $checks ->
        [one] { $checks } contrôle réussi
       *[other] { $checks } contrôles réussis
    }
already-armed = Déjà armé
checks-failed =
    { $checks ->
        [one] { $checks } contrôle échoué
       *[other] { $checks } contrôles échoués
    }
disarm = Désarmer
disarm-note = Arrête les moteurs
resume = Reprendre
resume-note = Reprend la main au pilote
takeoff = Décoller
takeoff-note = À la hauteur réglée
disarmed-by-itself = Les moteurs se sont coupés d'eux-mêmes : l'autopilote le fait quand aucun décollage ne suit l'armement. Armez à nouveau pour décoller.
takeoff-disarmed = Moteurs coupés d'eux-mêmes : armez à nouveau
takeoff-to = À { $height }
explore = Explorer
explore-note = Voir tout le parking
explore-again = À nouveau, { $distance }
explore-again-time = À nouveau, { $distance }, { $time }
explore-again-batteries = À nouveau, { $distance }, { $time }, { $batteries } batteries
move = Déplacer
move-note =
    { $pointer ->
        [finger] Puis touchez la carte
       *[mouse] Puis cliquez la carte
    }
move-now =
    { $pointer ->
        [finger] Touchez la carte
       *[mouse] Cliquez la carte
    }
move-running = Vers un autre point
home = Retour au départ
home-note = Et y atterrir
home-distance = { $distance }, { $time } jusqu'au sol
home-without-link = Sans liaison : de lui-même
land = Atterrir
land-note = À la verticale
land-running = Atterrissage
hold = Stationnaire
hold-note = S'arrêter sur place
running = En cours
running-percent = En cours, { $percent }
more-actions = Autres actions

no-link = Pas de liaison
on-the-ground = Au sol
not-possible = Impossible ici
not-in-control = Pas aux commandes
you-are-viewer = Vous êtes observateur
not-known-yet = Rien de reçu encore

## Qui a les commandes

viewer-title = Vous êtes observateur.
viewer-text = Un observateur voit tout et ne commande rien.
free-title = Personne n'a les commandes.
free-text = Prenez les commandes pour voler. Vous pouvez regarder sans.
lost-title = L'opérateur aux commandes est perdu.
lost-text = Prenez les commandes pour voler. Retour au départ et Atterrir sont ouverts à tous.
taken-text = Elles vous ont été prises : vous étiez perdu, ou sans réponse. Stationnaire vous reste ouvert à tout moment.
watching-title = Vous regardez. Un autre a les commandes.
watching-text = Stationnaire vous est ouvert à tout moment.
take-control = Prendre les commandes
ask-for-control = Demander les commandes
take-control-now = Prendre les commandes
withdraw = Renoncer
give = Donner
keep = Garder
give-control = Donner les commandes
keep-control = Garder les commandes
give-back = Rendre
give-back-control = Rendre la main
you-have-control = Vous commandez
nobody-has-control = Personne ne commande
operator-lost = Opérateur perdu
operator-in-control-lost = L'opérateur aux commandes est perdu
someone-has-control = Un autre commande
control-not-known = Commandes : état inconnu
you-had-control = Vous commandiez
no-control = Sans commandes
you-have-control-text = Les autres regardent ; chaque opérateur peut mettre en vol stationnaire.
take-in-bar = Prenez-les dans la barre du bas.
give-back-first = Rendez d'abord les commandes

was-asked = Les commandes sont demandées à { $name }.
does-not-answer = { $name } ne répond pas.
you-can-take-in = Sans réponse, vous pourrez prendre les commandes dans { $time }.
you-can-take-now = Vous pouvez prendre les commandes. Le drone continue ce qu'il fait.
asks-for-control = { $name } demande les commandes.
other-can-take-in = Sans réponse, { $name } pourra prendre les commandes dans { $time }.
other-can-take-now = Sans réponse, { $name } peut prendre les commandes maintenant.
release-title = Rendre les commandes en vol ?
release-text = Le drone reste en stationnaire, puis rentre et atterrit, sauf si quelqu'un prend les commandes.
release-text-for = Le drone reste en stationnaire pendant { $time }, puis rentre et atterrit, sauf si quelqu'un prend les commandes.

# Un plan du parking que quelqu'un a modifié en vol. $name : qui ; $lot : de quel parking.
plan-changed = Plan de { $lot } modifié, signé { $name }. Le suivre ?
fly-plan = Le suivre
leave-plan = Le laisser

# La page de la personne aux commandes est masquée pendant une tâche du drone.
hidden-warning = La page est masquée : regardez-la, sinon le drone rentre.

stopped-by = Arrêté par { $name }.
returning-by = Retour au départ, demandé par { $name }.
landing-by = Atterrissage, demandé par { $name }.
took-control = { $name } a pris les commandes : vous étiez perdu, ou sans réponse.
you-have-control-now = Vous avez les commandes.
other-has-control = { $name } a les commandes.
other-keeps-control = { $name } garde les commandes.
operator-keeps-control = L'opérateur garde les commandes.

## Questions dans la barre

slide-help = Glissez vers la droite, ou maintenez Entrée pendant une seconde
slide-missed = Page occupée : recommencez
arm-question = Démarrer les moteurs ?
arm-meaning = Tenez-vous loin des hélices.
arm-slide = Glisser pour armer
takeoff-question = Décoller ?
takeoff-question-to = Décoller à { $height } ?
takeoff-meaning = À la verticale de sa position.
takeoff-slide = Glisser pour décoller
explore-question = Explorer tout le parking ?
explore-meaning = Il vole seul dans la géobarrière. Stationnaire l'arrête.
explore-slide = Glisser pour explorer
home-question = Retourner au départ et y atterrir ?
home-slide = Glisser pour rentrer
land-question = Atterrir à la verticale ?
land-slide = Glisser pour atterrir
overrules = La radiocommande perd la main.
new-survey = Nouveau relevé
new-survey-question = Commencer un nouveau relevé ?
new-survey-meaning = La carte repart vide. Le dernier relevé reste enregistré sur le drone.
new-survey-slide = Glisser pour commencer
resume-question = Reprendre la main à la radiocommande ?
resume-meaning = Il s'arrête et reste sur place.
resume-slide = Glisser pour reprendre
move-slide = Glisser pour déplacer
cancel = Annuler
close = Fermer

## Déplacer

journey =
    { $to ->
        [north] { $distance } vers le nord
        [north-east] { $distance } vers le nord-est
        [east] { $distance } vers l'est
        [south-east] { $distance } vers le sud-est
        [south] { $distance } vers le sud
        [south-west] { $distance } vers le sud-ouest
        [west] { $distance } vers l'ouest
       *[north-west] { $distance } vers le nord-ouest
    }{ $then ->
        [climbing] , en montant à { $height }
        [sinking] , en descendant à { $height }
        [staying] , en restant à { $height }
       *[unknown] { "" }
    }
move-question = Déplacer de { journey } ?
look-again-question = Revoir la place { $stall } ?
look-again-line = Vol de { journey }.
move-typed = Ou saisir la distance
move-north = Nord, { $unit }
move-east = Est, { $unit }
move-height = Hauteur, { $unit }
move-from = Depuis
move-from-drone = le drone
move-from-home = le point d'armement
move-set = Placer
move-no-number = Nord, Est : donnez un nombre, négatif vers le sud ou l'ouest.
move-height-bounds = Hauteur : donnez un nombre de { $lowest } à { $highest }, ou aucun.
move-height-straight = À une hauteur propre, il vole tout droit
home-not-known = Le point d'armement n'est pas connu.
move-pill = { $distance }, { $time }
inside-lot = Dans le parking
inside-fence = Partout dans la géobarrière
where-may-fly = Où il peut voler
outside-fence = Hors de la géobarrière
in-zone = Dans une zone d'exclusion ou sa marge
leaves-fence = La ligne droite sort de la géobarrière
crosses-zone = La ligne droite traverse une zone d'exclusion
no-place-in-lot = Ce point n'est pas dans le parking
no-route = Aucun chemin n'y mène.
choose-inside = Hors de la géobarrière. Choisissez un point à l'intérieur du pointillé.
choose-out-of-zone = Dans une zone d'exclusion ou sa marge. Choisissez un point à l'intérieur du pointillé et hors des zones.
takes = { $time }.
takes-battery = { $time }, { $percent } environ de batterie.
stays-in-lot = Reste dans le parking.
stays-in-lot-distance = Reste dans le parking, { $distance } de trajet.
stays-in-fence = Dans la géobarrière, parking ou non.
exploring-stops = L'exploration s'arrête.
place-not-known = La position du drone n'est pas connue.
wait-for-position = Attendez sa position.

## La ligne du haut

state-idle = Au sol
state-configure = Réglage des hauteurs
state-arm = Armement
state-armed = Armé
state-takeoff = Décollage
state-hover = Stationnaire
state-explore = Exploration
state-move = Déplacement
state-home = Retour au départ
state-land = Atterrissage
state-operator-lost = Opérateur perdu
state-free = Sans opérateur
state-manual = Vol manuel
not-connected = Non connecté
waiting-for-drone = En attente du drone
looking-for-drone = Recherche du drone
was-in-state = { $state } il y a { $age }
autopilot-silent = Autopilote muet
autopilot-silent-text = L'ordinateur du drone ne l'entend pas
cutting-motors = Coupure des moteurs
cutting-motors-text = Envoyée jusqu'à l'arrêt des moteurs
cut-not-confirmed = Coupure non confirmée
cut-not-confirmed-text = Les moteurs tournent peut-être encore
fell = Moteurs arrêtés en vol
fell-text = Examinez le drone, puis levez le blocage pour armer de nouveau
motors-cut = Moteurs coupés
motors-cut-text = Levez la coupure pour armer de nouveau
fix-to-arm =
    { $checks ->
        [one] { $checks } contrôle échoué. Corrigez-le pour armer.
       *[other] { $checks } contrôles échoués. Corrigez-les pour armer.
    }
landed = Posé
motors-off-since = Moteurs arrêtés depuis { $time }
seen-of-outline = { $percent } du contour vus
seen-of-outline-time = { $percent } du contour vus, encore { $time } environ
found-so-far =
    { $stalls ->
        [one] { $stalls } place jusqu'ici
       *[other] { $stalls } places jusqu'ici
    }
found-so-far-time =
    { $stalls ->
        [one] { $stalls } place jusqu'ici, { $time } pour ce qui est en vue
       *[other] { $stalls } places jusqu'ici, { $time } pour ce qui est en vue
    }
seen-of-outline-short = { $percent } vus
seen-of-outline-time-short = { $percent } vus, encore { $time }
found-so-far-short = { $stalls } jusqu'ici
found-so-far-time-short = { $stalls } jusqu'ici, { $time } en vue
picture-old = Image d'il y a { $age }.
free-stalls = places libres
free-at = libres, à { $time }
parked = garés
parked-at = garés, à { $time }
battery = batterie
battery-percent = avant retour, { $percent }
then-percent = , { $percent }
height = hauteur
link-none = pas de liaison
link-lost = liaison perdue
link-slow = liaison lente
link-good = liaison bonne
link-autopilot-silent = autopilote muet
link-autopilot-slow = autopilote lent
simulation-mark = SIMULATION
simulation = Simulation
no-real-drone = Aucun drone réel ne vole.
desk = Bureau
desk-mark = BUREAU
desk-words = Parkings et plans. Aucun drone n'est ici.
some-lots = Vos parkings
some-lots-mark = VOS PARKINGS
some-lots-words = Vous êtes connecté en tant que { $name }.
some-lots-no-drone-title = Pas avec cette connexion
some-lots-no-drone = Votre connexion vaut pour certains parkings. Drone, image en direct et enregistrements demandent le jeton d'un rôle pour tous les parkings : déconnectez-vous, puis reconnectez-vous avec celui-ci.
menu = Menu
skip = Aller à
skip-to-actions = Aller aux actions
title = { $state } – Parking Lot Hawk
title-simulation = { $state } – Parking Lot Hawk (simulation)

## Couper les moteurs

cut-motors = Couper moteurs
cut-question = Couper les moteurs ?
cut-falls = Le drone tombe aussitôt. Seulement s'il va blesser quelqu'un.
cut-falls-from = Le drone tombe aussitôt de { $height }. Seulement s'il va blesser quelqu'un.
cut-instead = Pour l'arrêter sans danger : Stationnaire ou Atterrir.
cut-press = Maintenir 1 s pour couper
cut-missed = La page était trop occupée pour suivre l'appui : recommencez.
cut-not-allowed = Le drone ne l'a pas permis.
cut-too-long = C'était trop long. Annulez et recommencez.

## Le bandeau

never-connected-title = Pas connecté au drone
never-connected-text = Est-il allumé et à portée ? Cette page continue d'essayer.
no-word-title = Sans nouvelles du drone depuis { $age }
was-on-ground = Aux dernières nouvelles, il était au sol.
was-flown-by-hand = Aux dernières nouvelles, il était piloté à la radiocommande.
use-remote = Pour reprendre la main, utilisez la radiocommande.
goes-on-home = Selon ses réglages, il poursuit son retour au départ et y atterrit.
goes-on-landing = Selon ses réglages, il poursuit son atterrissage.
goes-on-otherwise = Un autre opérateur avait les commandes, ou il attendait déjà : il continue selon ses réglages.
returning-since = Selon ses réglages, il rentre depuis { $time } et atterrit au point de départ.
holds-now = Selon ses réglages, il est maintenant en stationnaire.
holds-at = Selon ses réglages, il continue jusqu'à { $time }, puis reste en stationnaire.
returns-at = À { $time }, il rentre et atterrit.
autopilot-acts = Si son ordinateur s'est arrêté, l'autopilote agit selon sa propre sécurité.
autopilot-acted-sooner = Si son ordinateur s'est arrêté, l'autopilote a agi plus tôt, selon sa propre sécurité.
autopilot-acts-sooner = Si son ordinateur s'est arrêté, l'autopilote agit plus tôt, selon sa propre sécurité.
mark-lost = perdue
mark-holds = stationnaire
mark-returns-in = retour au plus tard dans
mark-returned = rentré
connect = Connecter
autopilot-lost-title = L'ordinateur du drone n'entend pas l'autopilote
autopilot-lost-flying = Selon ses réglages, l'autopilote rentre au départ quand il n'entend rien. Pour reprendre la main, utilisez la radiocommande.
autopilot-lost-ground = L'autopilote est-il allumé et son câble branché ? L'ordinateur du drone continue d'essayer.
operator-was-lost = L'opérateur est perdu
holds-its-place = Il reste en stationnaire.
then-returns = Ensuite il rentre et atterrit.
returns-in = Dans { $time }, il rentre et atterrit.
take-control-to-go-on = Prenez les commandes pour continuer.
cut-unconfirmed-title = La coupure des moteurs n'est pas confirmée
cut-unconfirmed-text = Le drone n'a pas dit que les moteurs sont arrêtés. Coupez-les de nouveau s'il le faut encore.

## Le relevé sur la carte

survey-on-map = Un relevé est sur la carte
earlier =
    { $stalls ->
        [one] { $stalls } place. Le prochain vol le poursuit.
       *[other] { $stalls } places. Le prochain vol le poursuit.
    }
earlier-on =
    { $stalls ->
        [one] { $stalls } place sur { $area }. Le prochain vol le poursuit.
       *[other] { $stalls } places sur { $area }. Le prochain vol le poursuit.
    }
open-last-survey = Ouvrir le dernier relevé
continue-survey = Poursuivre le relevé

## Places de stationnement

free = libre
taken = occupée
unknown = incertaine
suggested = suggérée
legend-free = libres
legend-taken = occupées
legend-unknown = incertaines
stalls = Places
unclear-probably-free = incertaine, sans doute libre
unclear-probably-taken = incertaine, sans doute occupée
almost-surely-free = presque sûrement libre
almost-surely-taken = presque sûrement occupée
probably-free = sans doute libre
probably-taken = sans doute occupée
suggested-too =
    { $stalls ->
        [one] { $stalls } suggérée en plus
       *[other] { $stalls } suggérées en plus
    }
stood-in = Aucun marquage ici. Une voiture y était à { $passes } passages.
not-seen-itself = pas vue elle-même
not-seen-from-row = Pas vue elle-même, déduite de sa rangée.
seen-in =
    { $pictures ->
        [one] Vue sur { $pictures } image seulement.
       *[other] Vue sur { $pictures } images seulement.
    }
seen-in-last =
    { $pictures ->
        [one] Vue sur { $pictures } image seulement, la dernière à { $time }.
       *[other] Vue sur { $pictures } images seulement, la dernière à { $time }.
    }
last-seen = Vue pour la dernière fois à { $time }.
stall-number = Place { $stall }
stall-picture = Image de la place { $stall }
look-again = Revoir
from-home-by =
    { $to ->
        [north] { $distance } au nord du départ
        [north-east] { $distance } au nord-est du départ
        [east] { $distance } à l'est du départ
        [south-east] { $distance } au sud-est du départ
        [south] { $distance } au sud du départ
        [south-west] { $distance } au sud-ouest du départ
        [west] { $distance } à l'ouest du départ
       *[north-west] { $distance } au nord-ouest du départ
    }
no-stall-yet = Aucune place trouvée pour l'instant.
stalls-as-table = Tableau des places
stalls-caption =
    { $stalls ->
        [one] { $stalls } place, les libres d'abord, puis les plus proches du départ
       *[other] { $stalls } places, les libres d'abord, puis les plus proches du départ
    }
column-stall = Place
column-state = État
column-place = Position
column-seen = Vue
show-stall = Montrer la place { $stall } sur la carte
show-more = Afficher plus
show-survey = Voir le relevé
free-between = { $low } à { $high } sont libres dans le parking trouvé
counted-up-to = Décompte arrêté à { $time }
stalls-found =
    { $stalls ->
        [one] { $stalls } place trouvée
       *[other] { $stalls } places trouvées
    }
stalls-found-all =
    { $stalls ->
        [one] { $stalls } place trouvée, parking trouvé vu en entier
       *[other] { $stalls } places trouvées, parking trouvé vu en entier
    }
stalls-found-seen =
    { $stalls ->
        [one] { $stalls } place trouvée, { $percent } vus du parking trouvé
       *[other] { $stalls } places trouvées, { $percent } vus du parking trouvé
    }

## Le relevé après l'atterrissage

survey = Relevé
survey-so-far = Relevé jusqu'ici
survey-so-far-all = Relevé jusqu'ici, parking trouvé vu en entier
landed-at = Posé à { $time }
landed-at-all = Posé à { $time }, parking trouvé vu en entier
close-survey = Fermer le relevé
hero-free =
    { $free ->
        [one] { $free } libre
       *[other] { $free } libres
    }
hero-of =
    { $stalls ->
        [one] sur { $stalls } place trouvée
       *[other] sur { $stalls } places trouvées
    }
free-share = libres, { $percent }
taken-share = occupées, { $percent }
unknown-share = incertaines, { $percent }
in-the-air = en vol
flown = parcourus
lot-found = de parking trouvé
of-it-seen = en ont été vus
downloads = Téléchargements
file-table = Tableau
file-stalls = Places pour SIG
file-picture = Image du parking
file-recording = Enregistrement
file-kind-size = { $kind }, { $size }
lots-over-time = Dans le temps
lots = Parkings
lot-stalls =
    { $stalls ->
        [one] { $stalls } place
       *[other] { $stalls } places
    }
lot-sections =
    { $sections ->
        [one] { $sections } section
       *[other] { $sections } sections
    }
lot-surveys =
    { $surveys ->
        [one] { $surveys } relevé
       *[other] { $surveys } relevés
    }
# $when: a day
lot-seen = · vu le { $when }
clock-of = heure : { $city }
lot-clock = Heure
lot-clock-of-place = Celle de son lieu
link-shows-nothing = Ce lien ne montre rien
link-ended = Ce lien a pris fin ou a été repris. Demandez-en un autre à qui vous l'a envoyé.
link-too-often = Trop de faux liens sont venus de votre réseau. Attendez une minute, puis rechargez la page.
rename = Nom et heure
newest-survey = Dernier relevé
newest-survey-of = Dernier relevé : { $name }
rename-lot = Nom et heure de { $name }
name-of-lot = Nom du parking
which-lot = Quel parking est-ce ?
# $when: a day
survey-of = Relevé du { $when }
a-new-lot = Un nouveau parking
stalls-begin =
    { $stalls ->
        [one] { $stalls } place s’ajoute
       *[other] { $stalls } places s’ajoutent
    }
stalls-end =
    { $stalls ->
        [one] { $stalls } place disparaît
       *[other] { $stalls } places disparaissent
    }
stalls-added =
    { $stalls ->
        [one] { $stalls } place ajoutée
       *[other] { $stalls } places ajoutées
    }
stalls-removed =
    { $stalls ->
        [one] { $stalls } place retirée
       *[other] { $stalls } places retirées
    }
stalls-changed =
    { $stalls ->
        [one] { $stalls } place modifiée
       *[other] { $stalls } places modifiées
    }
areas-changed = zones et sections : { $names }
changed-on-drone = Par l’opérateur de { $drone }, pendant que le plan changeait ici
same-ground = { $name } est sur le terrain de ce parking
same-ground-share = { $share } du plus petit
merge-lot = Fusionner dans ce parking
show-on-map = Montrer sur la carte
take-over-changes = Reprendre
drop-changes = Écarter
begins = s’ajoute
ends = disparaît
end-confirmed =
    { $stalls ->
        [one] Supprimer aussi celle qui est confirmée
       *[other] Supprimer aussi les { $stalls } confirmées
    }
where-was-survey = Où était ce relevé ?
place-number = Position { $place }
here = Ici
here-place = Ici : position { $place }
stalls-of-lot = places du parking
stalls-of-survey = places du relevé

## Le plan d'un parking, corrigé par une personne

correct-plan = Corriger le plan
correct-plan-of = Corriger le plan : { $name }
survey-again = Relever à nouveau
survey-again-of = Relever à nouveau : { $name }
survey-again-taken = { $name } sera relevé à nouveau par Explorer.
choose-for-round = { $name } dans un vol au-dessus de plusieurs parkings
survey-again-round = Relever à nouveau { $lots } parkings en un vol
survey-again-due = Relever tous ceux qui sont prévus
round-taken = Les parkings seront relevés à nouveau par Explorer, en un vol.
day-plan = Plan de la journée
day-plan-batteries = Batteries pleines
day-plan-wind = Vent, m/s
day-plan-gust = Rafales, m/s
day-plan-cloud = Nuages, %
day-plan-rain = Pluie, mm
day-plan-file = Ou une prévision par heure (JSON)
day-plan-ask = Planifier la journée
day-plan-none = Aucun relevé n'est prévu dans les 24 prochaines heures.
day-plan-no-json = La prévision n'est pas du JSON : cherchez une virgule ou un crochet en trop.
day-plan-start = De { $start } à { $end } : { $names }
day-plan-no-start = Pas de départ : { $names }
day-plan-due = prévu à { $due }
day-plan-need = { $time }, { $distance }, batteries : { $batteries }
day-plan-not-at = Pas à { $times } :
day-plan-choose = Choisir
day-plan-choose-of = Choisir pour un vol : { $names }
plan-unanswered = Le drone n'a pas répondu : le plan n'a pas pu être lu.
plan-of = Plan : { $name }
plan-counts =
    { $stalls ->
        [one] { $stalls } place, { $confirmed } confirmée
       *[other] { $stalls } places, { $confirmed } confirmées
    }{ $guessed ->
        [0] { "" }
        [one] ; { $guessed } libellé supposé
       *[other] ; { $guessed } libellés supposés
    }
plan-you-edit = Vous modifiez depuis { $time }.
plan-other-edits = { $who } modifie depuis { $time }.
plan-nameless = Opérateur
plan-take-over = Prendre la main
plan-go-on = Continuer
plan-nobody-edits = Personne ne modifie. Votre premier changement ouvre une modification.
plan-no-edit = Votre modification a été close.
plan-opening = Ouverture…
plan-waits =
    { $steps ->
        [one] { $steps } changement attend.
       *[other] { $steps } changements attendent.
    }
plan-no-answer = Le drone ne répond pas.
plan-by-gnss = Placé par GNSS seul : le plan peut être décalé de quelques mètres sur l'image.
plan-by-itself = Pas encore de carte : le plan est affiché seul.
plan-steps-lost =
    { $steps ->
        [one] { $steps } changement du plan n'a pas été fait.
       *[other] { $steps } changements du plan n'ont pas été faits.
    }
plan-as-before = Le plan est inchangé.
plan-closed = Le plan est clos : version { $version } du tracé.
plan-leave-aloud = Quitter le plan ; votre modification reste ouverte
plan-close = Clore
plan-why = Motif, s'il y en a un
plan-tools = Outils du plan
plan-tool-choose = Choisir
plan-tool-box = Cadre
plan-tool-stall = Place
plan-tool-row = Rangée
plan-tool-area = Sans places
plan-tool-area-aloud = Sans places : une zone sans places
plan-tool-zone = Zone
plan-tool-section = Section
plan-redo = Rétablir
plan-choose-line =
    { $pointer ->
        [finger] Touchez des places ; deux fois pour la rangée. Faites glisser ce qui est choisi.
       *[mouse] Cliquez sur une place, avec Maj sur plusieurs ; double-cliquez pour sa rangée ; glissez avec Maj pour un cadre. Faites glisser ce qui est choisi, ou utilisez les flèches. R tourne, Suppr enlève.
    }
plan-box-line = Tracez un cadre sur des places.
plan-stall-line =
    { $pointer ->
        [finger] Touchez le lieu de la place. Elle s'aligne sur la rangée voisine.
       *[mouse] Cliquez sur le lieu de la place. Elle s'aligne sur la rangée voisine, sauf avec Alt.
    }
plan-row-begin =
    { $pointer ->
        [finger] Touchez un bout de l'avant de la rangée.
       *[mouse] Cliquez sur un bout de l'avant de la rangée.
    }
plan-row-end =
    { $pointer ->
        [finger] Touchez l'autre bout de l'avant.
       *[mouse] Cliquez sur l'autre bout de l'avant.
    }
plan-row-far =
    { $pointer ->
        [finger] Touchez le côté opposé de la rangée.
       *[mouse] Cliquez sur le côté opposé de la rangée.
    }
plan-row-whole = Changez le nombre, ou ajoutez la rangée.
plan-row-no-room = Trop peu d'espace : placez le côté opposé plus loin.
plan-area-line =
    { $pointer ->
        [finger] Touchez les sommets d'une zone sans places. Ses places disparaissent.
       *[mouse] Cliquez sur les sommets d'une zone sans places. Ses places disparaissent.
    }
plan-zone-line =
    { $pointer ->
        [finger] Touchez les sommets autour de places à compter ensemble.
       *[mouse] Cliquez sur les sommets autour de places à compter ensemble.
    }
plan-section-line =
    { $pointer ->
        [finger] Touchez le long d’un trottoir, ou autour d’une surface : les véhicules y sont comptés.
       *[mouse] Cliquez le long d’un trottoir, ou autour d’une surface : les véhicules y sont comptés.
    }
plan-chosen =
    { $stalls ->
        [0] Aucune place choisie
        [one] { $label } est choisie
       *[other] { $stalls } places choisies
    }
plan-labels-are =
    { $guessed ->
        [0] comme peint
       *[other] { $stalls ->
            [one] supposé
           *[other] { $guessed } libellés sur { $stalls } supposés
        }
    }
plan-labels = Libellés
plan-row-name = Nom de la rangée
plan-rename = Renommer
plan-swap = Échanger les noms
plan-swap-two = Échanger les noms : choisissez des places de deux rangées
plan-reverse = Numéroter depuis l’autre bout
plan-shift-by = Numéros { $by }
plan-key-up = Page préc.
plan-key-down = Page suiv.
plan-row-choice = Rangée
plan-row-none = Aucune
plan-row-all = Toutes les places
plan-confirm = Confirmer
plan-confirm-all = Confirmer tout
plan-remove = Enlever
plan-kind = Type
plan-kind-mixed = Plusieurs
plan-kind-normal = Pour tous
plan-kind-disabled = Handicapés (D)
plan-kind-charging = Électrique (E)
plan-kind-parent = Parents (P)
plan-kind-delivery = Livraison (L)
plan-kind-private = Réservé (R)
plan-kind-motorcycle = Motos (M)
plan-kind-staff = Personnel (S)
plan-kind-bus = Bus (B)
plan-kind-hgv = Poids lourds (H)
plan-kind-taxi = Taxis (T)
plan-more = Taille, angle, numéro
plan-width = Largeur, { $unit }
plan-length = Longueur, { $unit }
plan-set = Fixer
plan-set-size = Fixer la taille
plan-turn = Tourner de, °
plan-turn-do = Tourner
plan-parts = Parties
plan-split = Diviser
plan-letter = Lettre
plan-first = Premier numéro
plan-renumber = Renuméroter
plan-bad-number = { $field } : donnez un nombre.
plan-style = Places
plan-style-square = en bataille
plan-style-angled = en épi
plan-style-parallel = en créneau
plan-lean = Inclinaison, °
plan-double = Deux rangées dos à dos
plan-count = Nombre
plan-count-follows = Nombre ; { $count } selon le pas
plan-add-row = Ajouter la rangée
plan-add-row-of =
    { $stalls ->
        [one] Ajouter { $stalls } place
       *[other] Ajouter { $stalls } places
    }
plan-back = Retirer un point
plan-area-name = Nom de la zone, s'il y en a un
plan-area-private = Terrain privé, comme un jardin : les images l’omettent, rien n’y est compté
plan-private = terrain privé
plan-area-add = Ajouter la zone
plan-areas = Zones sans places
plan-area-nameless = Zone { $number }
plan-allow = Permettre
plan-allow-in = Permettre des places : { $name }
plan-zone-name = Nom de la zone
plan-zone-add = Ajouter la zone
plan-zones = Zones
plan-zone-erase-of = Enlever la zone { $name }
sections = Sections
section-shape = Forme
section-shape-strip = Bande
section-shape-area = Surface
section-side = Côté du tracé
section-side-right = droite
section-side-left = gauche
section-name = Nom de la section
section-kind = Les véhicules stationnent
section-kind-parallel = le long du trottoir
section-kind-across = en travers du trottoir
section-kind-any = sans ordre particulier
section-capacity = Places ; vide : selon la longueur
section-note = Note : riverains, livraisons, handicapés
section-add = Ajouter la section
section-change = Modifier
section-change-of = Modifier la section { $name }
section-remove-of = Retirer la section { $name }
section-of = Section { $name }
section-parked =
    { $parked ->
        [one] { $parked } garé sur { $capacity }
       *[other] { $parked } garés sur { $capacity }
    }
# $words: as section-parked
section-full = { $words }, plein
section-over = { $words }, plus que plein
section-vehicles =
    { $parked ->
        [one] { $parked } véhicule
       *[other] { $parked } véhicules
    }
section-unseen = pas vue
# $words: as section-parked, of the sections that were seen
sections-seen = { $words }, { $seen } sections vues sur { $sections }
section-interval = { $least } à { $most }, 9 fois sur 10.
section-room =
    { $room ->
        [0] Pas de place pour un autre.
       *[other] Place pour { $room } de plus.
    }
section-capacity-given = { $capacity } places, selon une personne
section-capacity-by-length = { $capacity } places selon sa longueur
section-no-capacity = nombre de places non indiqué
section-hidden = { $hidden } % est caché.
section-not-seen = { $unseen } % n’a pas été vu.
section-by-stalls = Les places occupées sont comptées : aucun véhicule n’est connu.
# Heads of the list of sections
section-head = Section
section-head-parked = Garés
section-head-between = 9 fois sur 10
section-head-room = Place libre
section-count = { $parked } ({ $least } à { $most })
section-differs = différent
section-then = { $before }, puis { $after }
section-may-be-same = peut-être égal
plan-import = Importer un plan
plan-import-reads = Lit le fichier…
plan-import-counts = { $begin } commencent, { $stay } changent, { $same } sont déjà ainsi, { $end } finissent.
plan-import-sections = Sections : { $begin } commencent, { $stay } changent, { $same } sont déjà ainsi, { $end } finissent.
plan-import-doubt = L’endroit du plan n’est pas certain :
plan-import-assumed = Supposé :
plan-import-left =
    { $count ->
        [one] { $count } élément laissé de côté
       *[other] { $count } éléments laissés de côté
    }
plan-import-clashes =
    { $count ->
        [one] { $count } libellé ou nom refusé : une autre place ou section le garde, ou deux fois dans le fichier
       *[other] { $count } libellés ou noms refusés : d’autres places ou sections les gardent, ou deux fois dans le fichier
    }
plan-import-number = Mettre un numéro derrière
plan-import-which =
    { $shown ->
        [one] Lequel, et pourquoi
       *[other] Lesquels, et pourquoi
    }
plan-import-choices = Choix pour ce fichier
plan-import-replace = Finir les places et les sections absentes du fichier
plan-import-rename = Numéroter les libellés et les noms que d’autres gardent
plan-import-layer = Couche
plan-import-label = Attribut des libellés
plan-import-crs = Système de coordonnées (EPSG:…)
plan-import-units = Unité du dessin
plan-import-point = Point { $number } : x,y,latitude,longitude
plan-import-again = Relire le fichier
plan-import-take = Prendre le plan
plan-import-take-so = Le prendre tel quel

## Batterie

battery-for-survey = Batterie pour le relevé
battery-charge = Batterie { $percent }
battery-home = Retour et réserve
battery-survey = Relevé
battery-left = Reste
battery-missing = Manque
battery-spoken = Batterie { $percent } : { $parts }. { $verdict }.
battery-spoken-home = retour et réserve { $percent }
battery-spoken-survey = relevé { $percent }
battery-spoken-left = reste { $percent }
battery-spoken-missing = manque { $percent }
battery-not-known = Le besoin du relevé n'est pas connu
battery-nothing-left = Il ne reste rien à relever
battery-enough-fence = Assez pour un parking aussi grand que la géobarrière
battery-enough-found = Assez pour le parking trouvé jusqu'ici
battery-enough-survey = Assez pour le reste du relevé
battery-part-fence = Assez pour { $percent } environ d'un parking aussi grand que la géobarrière
battery-part-found = Assez pour { $percent } environ du parking trouvé jusqu'ici
battery-part-survey = Assez pour { $percent } environ du reste du relevé
battery-low = Batterie faible : { $percent }. Il rentre bientôt.

## L'onglet du vol

nothing-known-yet = Rien de connu pour l'instant.
flight = Vol
health-of-parts = État de chaque élément
part-link = Liaison avec l'autopilote
part-position = Position
part-ground = Au sol ou non
part-home = Point de départ
part-rangefinder = Télémètre
part-remote-control = Radiocommande
part-remote-id = Identification à distance
part-witness = Second témoin
part-vision = Recherche des places
part-mapper = Carte
part-planner = Trajet
part-camera = Caméra
part-recording = Enregistrement
part-requests = Requêtes à l'autopilote
part-tasks = Parties du programme
part-loop = Ordinateur
part-working = fonctionne
parts-working = { $parts } sur { $parts } fonctionnent
parts-in-trouble = { $bad } sur { $parts } en panne
fact-autopilot = Autopilote
fact-speed = Vitesse
fact-from-home = Depuis le départ
fact-parts = Éléments
fact-place = Position
fact-from-armed = Depuis le point d'armement
fact-above-ground = Hauteur au-dessus du sol
fact-climbing = Montée
fact-wind = Vent
fact-gps = GPS
satellites =
    { $satellites ->
        [one] { $satellites } satellite
       *[other] { $satellites } satellites
    }
fact-voltage = Tension de la batterie
fact-pictures = Images analysées
each-second = { $value } par seconde
plot-height = Hauteur, { $unit }
plot-battery = Batterie, %
plot-now = maintenant

## Contrôles avant vol

checks = Contrôles
checks-before-flight = Contrôles avant vol
all-checks = Tous les contrôles
checks-not-known = pas encore connus
checks-all-passed = { $checks } sur { $checks } réussis
checks-some-passed = { $passed } sur { $checks } réussis
remedy-failsafes = Régler les sécurités
remedy-kill = Autoriser l'armement
remedy-fence = Tracer la géobarrière
show-checks = Voir les contrôles
remedy-mends =
    { $checks ->
        [one] Corrige { $checks } contrôle échoué
       *[other] Corrige { $checks } contrôles échoués
    }
remedy-by-hand =
    { $checks ->
        [one] { $checks } échoué : que faire
       *[other] { $checks } échoués : que faire
    }

## Hauteurs

heights = Hauteurs
heights-not-known = pas encore connues
flies-at-height = Vole à { $height }
never-below-or-above = jamais sous { $lowest } ni au-dessus de { $highest }
change-heights = Changer les hauteurs
heights-unit =
    { $units ->
        [feet] Pieds au-dessus du point d'armement.
       *[metres] Mètres au-dessus du point d'armement.
    }
save-heights = Enregistrer
heights-not-stored = Pas enregistré.
lowest-label = Jamais sous (Min)
desired-label = Vole à (Des)
highest-label = Jamais au-dessus (Max)
lowest-no-number =
    { $units ->
        [feet] Jamais sous : donnez un nombre de pieds supérieur à 0.
       *[metres] Jamais sous : donnez un nombre de mètres supérieur à 0.
    }
desired-no-number =
    { $units ->
        [feet] Vole à : donnez un nombre de pieds supérieur à 0.
       *[metres] Vole à : donnez un nombre de mètres supérieur à 0.
    }
highest-no-number =
    { $units ->
        [feet] Jamais au-dessus : donnez un nombre de pieds supérieur à 0.
       *[metres] Jamais au-dessus : donnez un nombre de mètres supérieur à 0.
    }
desired-too-low = Vole à : { $height } est sous la hauteur minimale de { $lowest }.
desired-too-high = Vole à : { $height } est au-dessus de la hauteur maximale de { $highest }.
highest-above-fence = Jamais au-dessus : la géobarrière s'arrête à { $ceiling }.

## Géobarrière

fence = Géobarrière
corners-and-zones =
    { $corners ->
        [one] { $corners } sommet
       *[other] { $corners } sommets
    }{ $zones ->
        [0] { "" }
        [one] , { $zones } zone
       *[other] , { $zones } zones
    }
fence-of = Géobarrière de { corners-and-zones }
fence-sized = Géobarrière { $extent }, { corners-and-zones }
limits-not-known = pas encore connue
fence-unusable = La géobarrière tracée est inutilisable
fence-drawn-up-to = tracée, jusqu'à { $ceiling }
fence-file-up-to = des réglages, jusqu'à { $ceiling }
fence-circle = Géobarrière : cercle de { $radius }
fence-circle-up-to = autour du point d'armement, jusqu'à { $ceiling }
fence-no-link = Pas de liaison : ni contrôle ni enregistrement.
fence-cannot-save = Cette géobarrière ne peut pas être enregistrée
put-right = Corrigez ce qui est dit
being-checked = Contrôle en cours
being-checked-line = Contrôle en cours.
being-saved = Enregistrement en cours
nothing-changed = Rien de changé
not-closed-yet = Pas encore fermée
zone-not-closed-yet = Zone pas encore fermée
draw-fence = Tracer la géobarrière
draw-fence-begin =
    { $pointer ->
        [finger] Touchez ses sommets sur la carte, l'un après l'autre. Ou importez un fichier.
       *[mouse] Cliquez ses sommets sur la carte, l'un après l'autre. Ou importez un fichier.
    }
draw-fence-few =
    { $corners ->
        [one] { $corners } sommet posé. Il en faut au moins 3 à une géobarrière.
       *[other] { $corners } sommets posés. Il en faut au moins 3 à une géobarrière.
    }
draw-close =
    { $pointer ->
        [finger] { $corners } sommets posés. Touchez de nouveau le premier, ou le bouton Fermer.
       *[mouse] { $corners } sommets posés. Cliquez de nouveau le premier, ou le bouton Fermer.
    }
draw-zone = Tracez une zone où le drone n'entre pas
draw-zone-begin =
    { $pointer ->
        [finger] Touchez ses sommets, dans la géobarrière. Le bouton Zone l'abandonne.
       *[mouse] Cliquez ses sommets, dans la géobarrière. Le bouton Zone l'abandonne.
    }
draw-zone-few =
    { $corners ->
        [one] { $corners } sommet posé. Il en faut au moins 3 à une zone.
       *[other] { $corners } sommets posés. Il en faut au moins 3 à une zone.
    }
remove-corners-line =
    { $pointer ->
        [finger] Touchez les sommets à supprimer.
       *[mouse] Cliquez les sommets à supprimer.
    }
remove-zones-line =
    { $pointer ->
        [finger] Touchez les sommets à supprimer, ou une zone pour la supprimer.
       *[mouse] Cliquez les sommets à supprimer, ou une zone pour la supprimer.
    }
stays-inside = Le drone reste { $margin } à l'intérieur, au pointillé, et sous { $height }.
edit-the-fence = Modifier la géobarrière
edit-fence = Modifier
save-fence = Enregistrer
ceiling = Plafond
ceiling-label =
    { $units ->
        [feet] Plafond, pieds au-dessus du point d'armement
       *[metres] Plafond, mètres au-dessus du point d'armement
    }
ceiling-no-number = Plafond : donnez un nombre supérieur à 0.
set-aside = Écarter
set-aside-label = Écarter la géobarrière tracée
set-aside-what = Écarter la géobarrière tracée
fence-saved = La géobarrière est enregistrée. Le prochain Armer l'envoie.
fence-not-saved = La géobarrière n'est pas enregistrée.
fence-not-checked = Le contrôle n'a pas pu se faire.
fence-on-ground-only = La géobarrière se modifie au sol seulement, moteurs arrêtés.
drawing-kept = Le tracé est gardé.

## Outils de tracé

fence-tools = Outils de géobarrière
outline-tools = Outils de contour
fence-file = Fichier de géobarrière
outline-file = Fichier de contour
tool-remove = Ôter
tool-remove-aloud = Ôter des sommets
close-ring = Fermer le tracé
tool-square = Carré
tool-undo = Annuler
tool-zone = Zone
tool-zone-aloud = Zone d'exclusion : en ajouter une
tool-hole = Trou
tool-hole-aloud = Trou : ajouter une partie non explorée
tool-clear = Effacer
tool-import = Importer
tool-export = Exporter
file-unanswered = Le drone n’a pas répondu : le fichier n’a pas pu être lu.
file-too-large = Le fichier est trop gros pour une aire.

file-one-polygon =
    { $kind ->
        [fence] Le fichier doit contenir exactement un polygone. Enregistrez la géobarrière seule, en GeoJSON.
       *[outline] Le fichier doit contenir exactement un polygone. Enregistrez le contour seul, en GeoJSON.
    }
file-not-geojson =
    { $kind ->
        [fence] Le fichier n'est pas du GeoJSON. Enregistrez la géobarrière en GeoJSON.
       *[outline] Le fichier n'est pas du GeoJSON. Enregistrez le contour en GeoJSON.
    }
file-zone-holes = Une zone d'exclusion doit être un seul anneau, sans trou.
file-no-ring = Le polygone n'a pas d'anneau de sommets.
file-polygon-few = Nombre de sommets du polygone : { $corners }. Il en faut au moins 3.
file-zone-few = Nombre de sommets de la zone { $zone } : { $corners }. Il en faut au moins 3.
file-polygon-no-place = Le polygone : le sommet { $corner } n'est pas un point de la Terre. La longitude vient avant la latitude, en degrés (WGS-84).
file-zone-no-place = Zone { $zone } : le sommet { $corner } n'est pas un point de la Terre. La longitude vient avant la latitude, en degrés (WGS-84).

## L'aire à explorer

outline-on-ground-only = Au sol seulement, moteurs arrêtés
outline-several = Il a plusieurs polygones : supprimez-le d'abord
area-to-explore = Aire à explorer
explores-found-lot = Explore le parking qu'il trouve
no-outline = aucun contour défini
explores-outline = Explore un contour de { $area }
polygons-and-holes =
    { $polygons ->
        [one] { $polygons } polygone
       *[other] { $polygons } polygones
    }{ $holes ->
        [0] { "" }
        [one] , { $holes } trou
       *[other] , { $holes } trous
    }
outline-from-file = { polygons-and-holes }, des réglages
outline-set = { polygons-and-holes }, défini pour ce relevé
corners-and-holes =
    { $corners ->
        [one] { $corners } sommet
       *[other] { $corners } sommets
    }{ $holes ->
        [0] { "" }
        [one] , { $holes } trou
       *[other] , { $holes } trous
    }
outline-sized = Contour de { $area }, { corners-and-holes }
outline-of = Contour, { corners-and-holes }
draw-area = Tracer l'aire à explorer
draw-hole = Tracez une partie à ne pas explorer
draw-area-begin =
    { $pointer ->
        [finger] Touchez ses sommets sur la carte, l'un après l'autre. Ou importez un fichier.
       *[mouse] Cliquez ses sommets sur la carte, l'un après l'autre. Ou importez un fichier.
    }
draw-hole-begin =
    { $pointer ->
        [finger] Touchez ses sommets sur la carte, l'un après l'autre. Le bouton Trou l'abandonne.
       *[mouse] Cliquez ses sommets sur la carte, l'un après l'autre. Le bouton Trou l'abandonne.
    }
draw-ring-few =
    { $corners ->
        [one] { $corners } sommet posé. Il en faut au moins 3.
       *[other] { $corners } sommets posés. Il en faut au moins 3.
    }
outline-no-link = Pas de liaison : le contour ne peut pas être défini.
outline-cannot-set = Ce contour ne peut pas être défini
outline-crosses = Deux de ses côtés se croisent : déplacez un sommet.
being-set = Envoi en cours
outline-meaning = Le prochain Explorer voit tout ce contour dans la géobarrière, et rien d'autre.
set-outline = Définir le contour
edit-outline = Modifier le contour
draw-outline = Tracer le contour
last-outline = Dernier contour
last-outline-label = Dernier contour : le reprendre
remove = Supprimer
remove-outline = Supprimer le contour
set-outline-what = Définir le contour
outline-is-set = Le contour est défini. Le prochain Explorer le voit tout entier dans la géobarrière.
outline-is-removed = Le contour est supprimé. Le prochain Explorer cherche lui-même le parking.
outline-paused = L'aire à explorer se trace au sol seulement, moteurs arrêtés.

## Carte

map = Carte
map-of-lot = Carte du parking
zoom-in = Agrandir
zoom-out = Réduire
follow-drone = Suivre le drone
whole-lot = Tout le parking
turn-with-drone = Tourner la carte avec le drone
drone-up = Le nez du drone est en haut. Appuyez pour le nord en haut
north-up = Le nord est en haut. Appuyez pour tourner la carte avec le drone
north-on-map = Nord sur la carte
north-letter = N
layers = Couches
shown-on-map = Affiché sur la carte
layer-stalls = Places
layer-picture = Image du sol
layer-fence = Géobarrière et zones
layer-outline = Aire à explorer
layer-trail = Trajet parcouru
layer-background = Fond de carte
last-seen-here = Vu ici il y a { $age }
ring-of-reach = Le cercle : où il peut être à présent
no-map-yet = Pas encore de carte
map-fills = Elle se remplit pendant le vol. Le pointillé est la géobarrière : le drone reste à l'intérieur.
map-begins = Elle commence où le drone est armé, et se remplit pendant le vol.

## Mesurer sur la carte

measure = Mesurer
measure-begin =
    { $pointer ->
        [finger] Touchez deux points ou plus.
       *[mouse] Cliquez deux points ou plus.
    }
measure-next =
    { $pointer ->
        [finger] Touchez le point suivant.
       *[mouse] Cliquez le point suivant.
    }
measure-go-on =
    { $pointer ->
        [finger] Touchez d'autres points pour continuer.
       *[mouse] Cliquez d'autres points pour continuer.
    }
measure-close =
    { $pointer ->
        [finger] Touchez le premier point pour fermer et voir l'aire.
       *[mouse] Cliquez le premier point pour fermer et voir l'aire.
    }
measure-again =
    { $pointer ->
        [finger] Touchez pour recommencer.
       *[mouse] Cliquez pour recommencer.
    }
measure-around = { $length } de pourtour
measure-area-around = { $area }, { $length } de pourtour
measure-crosses = Ses côtés se croisent : il n'a pas d'aire unique.
measure-back = Ôter le dernier point
measure-stop = Ne plus mesurer

## Image en direct

live-video = Vidéo en direct
camera-picture = Image de la caméra, à la verticale, places entourées
live-picture = Image en direct
swap-map-video = Échanger carte et vidéo
full-screen = Plein écran
save-picture = Enregistrer cette image
small-window = Afficher dans une petite fenêtre
close-small-window = Fermer la petite fenêtre
north-in-picture = Nord dans l'image
live-age = Direct, { $age }
simulation-age = Simulation, { $age }
simulation-age-old = Simulation, il y a { $age }
frozen = Figée
simulation-frozen = Simulation, figée
no-picture-yet = Pas encore d'image
picture-is-old = Image d'il y a { $age }
no-new-picture = Aucune nouvelle image n'arrive
waiting-for-camera = En attente de la caméra

## Messages

messages = Messages
nothing-happened = Rien ne s'est encore passé.
no-message-like-this = Aucun message ne correspond.
messages-filtered = { $found } messages sur { $all }
show-all-messages = Tout montrer
search-messages = Chercher
warnings = Alertes
save = Enregistrer
details = Détails
link-lost-note = Liaison perdue.
link-back-note = Liaison rétablie.
refused = { $what } : { $reason }
no-reason = sans raison donnée
not-sent = Pas de liaison avec le drone. Rien n'a été envoyé.
no-answer = Pas de réponse. On ne sait pas si le drone l'a reçu.
link-lost-before-answer = La liaison s'est perdue. On ne sait pas si le drone l'a reçu.
log-out-unanswered = Déconnexion : le drone n'a pas répondu. Réessayez.

## Réglages

about-flight = À propos du vol
settings = Réglages
appearance = Apparence
theme-auto = Comme l'appareil
theme-light = Clair
theme-dark = Sombre
theme-outdoor = Plein soleil
units = Unités
units-metres = Mètres
units-feet = Pieds
units-note = Les messages du drone restent en mètres.
language = Langue
language-auto = Comme le navigateur
language-note = Ce que dit l'autopilote reste en anglais.
left-handed = Gaucher
left-handed-note = Stationnaire et Atterrir dans le coin inférieur gauche
sound = Son
sound-note = Son et voix : liaison perdue, batterie faible, actions des autres
logged-in-viewer = Connecté comme observateur
logged-in-operator = Connecté comme opérateur
on-this-browser = Sur ce navigateur
log-out = Se déconnecter
version = Parking Lot Hawk { $version }
licences = Licences
documentation = Documentation
documentation-of = Documentation de Parking Lot Hawk { $version }
your-name = Votre nom
name-question = Quel est votre nom ?
others-read = Les autres lisent : { $name }
others-read-it = Les autres le lisent à côté de ce que vous faites
all-settings = Tous les réglages du programme du drone
settings-unanswered = Le drone ne répond pas. Fermez et rouvrez cette liste.
settings-asking = Demande au drone
settings-note = Ils sont lus au démarrage du programme : dans config.toml, ou dans HAWK_SECTION__KEY de son environnement.
search-settings = Chercher un réglage
no-setting-like-this = Aucun réglage ne correspond.
setting-changed = modifié
setting-not-set = non défini
setting-none = aucun
setting-bounds = de { $lowest } à { $highest }

## Touches

keys = Touches
all-keys = Toutes les touches
keys-note = Inactives pendant la frappe.
key-hold = Stationnaire : s'arrêter sur place, aussitôt
key-move = Déplacer : puis cliquez la carte
key-resume = Reprendre après un vol manuel
key-swap = Vidéo en grand, carte en petit, et retour
key-survey = Voir le relevé
key-keys = Afficher ces touches
key-escape = Quitter la question
key-tab = Au bouton suivant
key-enter = L'appuyer ; maintenue sur une glissière : la glisser
escape-key = Échap
tab-key = Tab
enter-key = Entrée

## Les parkings dans le temps : les vues lues à l’ouverture

archive-title = Les parkings dans le temps
at-a-glance = Le drone en un coup d'œil
views = Vues
view-fly = Voler
view-lots = Parkings
view-compare = Comparer
view-report = Rapport
view-recordings = Enregistrements
title-view = { $view } · { $lot }
no-drone = Pas de drone
time-bar = Relevés par jour et heure
time-bar-before = Jours précédents
time-bar-after = Jours suivants
time-bar-span = Jours montrés par la barre
time-bar-day = Jour
time-bar-week = Semaine
time-bar-month = Mois
time-bar-few = 3 jours
time-bar-play = Rejouer le vol
time-bar-today = { $day }, aujourd'hui
time-bar-nobody = personne n'a volé
time-bar-open-day = À partir de { $time } : { $count } relevés. Ouvrir le jour
time-bar-deleted = { $time } supprimé
time-bar-bring-back = Rétablir
time-bar-due-in =
    { $hours ->
        [0] prévu dans { $minutes } min
       *[other] prévu dans { $hours } h { $minutes } min
    }
time-bar-due = prévu à { $time }
time-bar-due-since = prévu depuis { $time }
time-bar-not-counted = aucun chiffre ne l'utilise
time-bar-more =
    { $count ->
        [one] et un autre
       *[other] et { $count } autres
    }
changes = Modifications
change-delete = Relevé supprimé
change-merge = Un autre parking fusionné avec celui-ci
change-move = Relevé déplacé
change-name = Parking nommé
change-place = Lieu d'un relevé choisi
change-plan = Plan corrigé
change-split = Parking divisé
change-time-zone = Fuseau horaire choisi
change-take-over = Modifications reprises dans le plan
change-drop = Propositions écartées
change-pin = Parking fixé à son lieu
change-import = Plan importé
change-undone = annulé
change-undo = Annuler : { $change }, { $when }
archive-delete-survey-surely = Supprimer ce relevé
archive-list = Liste des relevés
edit-plan = Modifier le plan
share-lot = Partager
export-survey = Exporter
survey-found = Le vol lui-même a trouvé { $found } places. Les comptes portent sur les { $stalls } du plan.
archive-free-of = libres sur { $stalls } places
archive-no-picture = L'image de ce relevé n'est pas gardée.
archive-row = Rangée
archive-view-parts = Parties de cette vue
archive-ask-again = Demander de nouveau
archive-lot = Parking
archive-from = Du
archive-to = Au
archive-surveys = Relevés
archive-stalls = Places
archive-links = Liens
archive-unanswered = Pas de réponse : vérifiez la liaison. La page redemande d’elle-même.
archive-refused = Le drone a refusé (HTTP { $status }). Rechargez la page.
archive-asking = Demande au drone
archive-no-lot = Aucun parking n'est encore enregistré : faites un premier relevé.
archive-no-survey = Ce parking n'a pas de relevé : volez, ou comptez-le d'après des photographies.
archive-two-needed = Il faut deux relevés qui comptent : volez encore.
archive-none-counts = Aucun relevé de cette période ne compte : choisissez d'autres jours, ou donnez sa position à un relevé dans Voler.
archive-program = Programme { $program }
survey-gone = Le relevé de cette adresse n'est pas là : il a été supprimé ou déplacé. Le plus récent est montré.
lot-gone = Le parking de cette adresse n'est pas là : il a été réuni à un autre ou effacé. Un autre est montré.
archive-when = Quand
archive-free = Libres
archive-taken = Occupées
archive-unknown = Incertaines
archive-occupancy = Occupation
archive-note = Remarque
archive-counts = { $free } libres, { $taken } occupées, { $unknown } incertaines
archive-survey-of = Relevé du { $when }
archive-files = Fichiers
archive-delete-survey = Supprimer le relevé
archive-survey-deleted = Le relevé du { $when } est supprimé.
archive-undo = Annuler
archive-simulated = Simulé
archive-blurred = Places vues floues seulement : { $blurred } sur { $stalls }
archive-of-photographs = D'après des photographies ({ $name })
archive-of-orthophoto = D'après une orthophoto ({ $name })
archive-of-film = D'après un film ({ $name })
archive-limit-by-gps = Ses images sont là où leurs fichiers le disent : les places peuvent être décalées de quelques mètres
archive-limit-stretched = Sa carte peut être tournée ou étirée : les places à ses bouts peuvent être décalées de quelques mètres
archive-limit-coarse = Ses images sont grossières : moins de places sont trouvées
archive-limit-partly = Une partie du parking n'a pas été vue
archive-long = Il a duré { $minutes } min : des voitures sont arrivées et parties entre-temps
archive-why-unregistered = Sa position sur le parking n'est pas certaine
archive-why-time = Son heure n'est pas certaine
archive-why-looks = Il n'a regardé aucune place du parking
archive-left-out = Aucun chiffre n'utilise ce relevé. { $why }.
archive-left-out-count =
    { $surveys ->
        [one] { $surveys } relevé de cette période est écarté : sa position ou son heure n'est pas certaine.
       *[other] { $surveys } relevés de cette période sont écartés : leur position ou leur heure n'est pas certaine.
    }
archive-share = { $value } % ({ $low } à { $high } %)
archive-before = Avant
archive-after = Après
archive-changes = Places changées
compare-day-time = { $day }, { $time }
compare-modes = Manière de comparer
compare-swipe = Glisser
compare-fade = Fondre
compare-side = Côte à côte
compare-swipe-handle = Ligne entre les deux relevés
compare-fade-handle = Part visible du second relevé
compare-swipe-at = { $share } % de la carte montre { $after }, le reste { $before }
compare-fade-at = { $after } visible à { $share } %, sur { $before }
compare-free-of = { $free } libres sur { $stalls }
compare-not-there = Absente du plan de ce relevé
compare-ends = Relevés comparés
compare-end-before = avant
compare-end-after = après
compare-choose = Un appui sur la barre du bas choisit : { $end }.
compare-end-gone = Le relevé { $end } de cette adresse n'est pas là : il a été supprimé ou déplacé. Le plus récent est montré.
compare-none-seen = Rien à comparer
compare-as-many = Autant de places libres qu'avant
compare-more =
    { $count ->
        [one] { $count } libre de plus
       *[other] { $count } libres de plus
    }
compare-fewer =
    { $count ->
        [one] { $count } libre de moins
       *[other] { $count } libres de moins
    }
compare-of = sur les { $stalls } vues dans les deux
compare-interval-more = De { $low } à { $high } de plus, { $times } fois sur 10.
compare-interval-fewer = De { $low } à { $high } de moins, { $times } fois sur 10.
compare-interval-both = De { $fewer } de moins à { $more } de plus, { $times } fois sur 10.
compare-became = Devenues occupées : { $taken }, libres : { $free }, incertaines : { $unknown }.
compare-unclear =
    { $count ->
        [one] { $count } place est incertaine dans l'un des deux : pas comptée.
       *[other] { $count } places sont incertaines dans l'un des deux : pas comptées.
    }
compare-new =
    { $count ->
        [one] { $labels } est nouvelle depuis : pas comparée.
       *[other] { $rest ->
            [0] { $labels } sont nouvelles depuis : pas comparées.
           *[other] { $labels } et { $rest } autres sont nouvelles depuis : pas comparées.
        }
    }
compare-gone =
    { $count ->
        [one] { $labels } n'existe plus : pas comparée.
       *[other] { $rest ->
            [0] { $labels } n'existent plus : pas comparées.
           *[other] { $labels } et { $rest } autres n'existent plus : pas comparées.
        }
    }
compare-redrawn =
    { $count ->
        [one] { $count } place a été redessinée dans le plan : comparée par son sol.
       *[other] { $count } places ont été redessinées dans le plan : comparées par leur sol.
    }
compare-row =
    { $count ->
        [one] Rangée { $row }, { $count } changement
       *[other] Rangée { $row }, { $count } changements
    }
compare-row-none =
    { $count ->
        [one] Autres places, { $count } changement
       *[other] Autres places, { $count } changements
    }
compare-nothing = Aucune place n'a changé d'état.
compare-states = { $before }, maintenant { $after }
archive-stall = Place
archive-by-row = Rangées
archive-by-zone = Zones
archive-by-kind = Types
archive-by-section = Sections
archive-heat = Part des relevés qui ont trouvé chaque place occupée
archive-heat-note =
    { $surveys ->
        [one] Part de { $surveys } relevé qui a trouvé chaque place occupée.
       *[other] Part de { $surveys } relevés qui ont trouvé chaque place occupée. Choisissez une place pour voir ses derniers regards.
    }
archive-stall-of = Place { $label }
archive-stall-share =
    { $surveys ->
        [one] Part du { $surveys } relevé qui l'a vue, où elle était occupée :
       *[other] Part des { $surveys } relevés qui l'ont vue, où elle était occupée :
    }
archive-state-free = libre
archive-state-taken = occupée
archive-state-unknown = incertaine
archive-no-zone = Dans aucune zone
archive-chance-taken = probabilité d'occupée { $value } %
archive-unseen = Pas vue
ask-question = Quelle part de { $part } est occupée { $days } { $hours ->
        [all] à
       *[some] entre
    } { $clock } { $period ->
        [all] sur
        [month] en
       *[days] du
    } { $when } ?
ask-question-part = La question
ask-part = Partie du parking
ask-days = Jours de la semaine
ask-hours = Heures de la journée
ask-period = Période
ask-whole-lot = tout le parking
ask-rows =
    { $count ->
        [one] la rangée { $names }
       *[other] les rangées { $names }
    }
ask-every-day = tous les jours
ask-every-hour = toute heure
ask-every-survey = tous les relevés
ask-run = { $first }–{ $last }
ask-hours-run = { $first } et { $last } h
ask-hour = { $hour } h
ask-since = { $day } à aujourd'hui
ask-until = premier relevé au { $day }
ask-dates = { $first } au { $last }
ask-month-surveys =
    { $surveys ->
        [one] { $month }, { $surveys } relevé
       *[other] { $month }, { $surveys } relevés
    }
ask-taken = { $value } % occupé
ask-low-high = { $low } à { $high } %
ask-stalls =
    { $exact ->
        [yes] { $low } des { $stalls } places sont occupées en moyenne.
       *[no] { $low } à { $high } des { $stalls } places sont occupées en moyenne.
    }
ask-ends = Le plus plein le { $fullDay } à { $fullHour } ({ $full }), le plus vide le { $emptyDay } à { $emptyHour } ({ $empty }).
ask-behind = D'après { $surveys ->
        [one] { $surveys } relevé
       *[other] { $surveys } relevés
    } sur { $days ->
        [one] { $days } jour
       *[other] { $days } jours
    }, { $dates }, { $clock }.
ask-nobody-at = Personne n'a volé à { $hours }.
ask-none = Personne n'a volé à ce moment.
ask-none-counts = Aucun relevé de ce moment ne compte.
ask-none-remedy = Choisissez d'autres heures, d'autres jours ou une période plus longue.
ask-heat = { $part } par jour et heure, { $when }
ask-heat-keys = Les flèches vont d'heure en heure, Maj et flèches en choisissent plusieurs, Entrée pose la question.
ask-range = { $low } à { $high }
ask-places = { $value } véhicules ({ $low } à { $high }) sont garés sur { $places } places en moyenne.
ask-vehicles = { $value } véhicules ({ $low } à { $high }) sont garés en moyenne. Le nombre de places n’est pas indiqué.
ask-vehicles-large = { $value } véhicules
ask-head-vehicles = Véhicules
ask-scale-vehicles = 0 à { $most } véhicules
ask-scale = occupé de 0 à 100 %
ask-nobody = personne n'a volé
ask-asked = demandé
ask-whole-week = Toute la semaine
ask-all-hours = 24 heures
ask-flown-hours = Heures relevées
ask-hour-from = { $first }–{ $last } h
ask-cell = { $day } { $hours } : { $what }
ask-cell-flown =
    { $surveys ->
        [one] { $value }, { $surveys } relevé, { $range }
       *[other] { $value }, { $surveys } relevés, { $range }
    }
ask-surveys =
    { $surveys ->
        [one] { $surveys } relevé
       *[other] { $surveys } relevés
    }
ask-figures = Les chiffres derrière
ask-times = { $times } fois sur 10
ask-all = Tout, chaque relevé une fois
ask-elsewhere = La même chose, ailleurs
ask-other-rows = Autres rangées, mêmes heures :
ask-command = Dans un terminal
ask-copy-command = Copier la ligne
ask-copy-address = Copier l'adresse de cette question
ask-copied = Copié : { $text }
ask-copy-by-hand = Ce navigateur ne laisse pas la page copier. Copiez à la main : { $text }
ask-document = Le rapport : l'imprimer ou le télécharger
ask-done = Terminé
document-title = Le rapport de ce qui est demandé
document-paper = Papier
document-pdf = PDF
document-xlsx = Classeur
document-writing = { $kind } : le drone l'écrit
document-saved = { $name } est enregistré, { $size }.
document-refused = { $kind } : { $why }
document-print-instead = Imprimez-le plutôt par le navigateur.
archive-print = Imprimer
archive-no-recording = Il n'y a aucun enregistrement ici.
archive-recordings-size =
    { $count ->
        [one] { $count } enregistrement, { $size }
       *[other] { $count } enregistrements, { $size }
    }
archive-length = Durée
archive-size = Taille
archive-keep = Garder
archive-keep-of = Garder l'enregistrement du { $when }
archive-file = Fichier
archive-under-way = En cours
archive-download = Télécharger
archive-download-of = Télécharger l'enregistrement du { $when }
archive-delete = Supprimer
archive-delete-of = Supprimer l'enregistrement du { $when }
archive-delete-surely = Supprimer pour de bon
archive-delete-surely-of = Supprimer pour de bon l'enregistrement du { $when }
archive-links-note = Un lien montre ce parking à tous ceux qui l'ont, sans connexion : chaque relevé, ceux à venir aussi, avec comptes, places, chiffres et rapport. Il ne montre ni enregistrement, ni opérateur, ni autre parking, et ne change rien. Il finit de lui-même, et peut être repris.
archive-link-days = Jours
archive-make-link = Créer un lien
archive-link = Lien
archive-link-made = Ce lien est montré une seule fois. Il finit le { $ends }.
archive-link-open = Créé le { $made }, finit le { $ends }
archive-link-shut = Créé le { $made }, fermé
archive-take-back = Reprendre

asked-recordings-ask = Demander l'enregistrement
asked-recordings-take-back = Ne plus demander
asked-recordings-asked = L'enregistrement est demandé à { $drone }, qui l'envoie au sol.
asked-recordings-coming = { $received } sur { $size } de l'enregistrement sont arrivés. { $drone } l'envoie au sol.
asked-recordings-never = { $drone } ne donne aucun enregistrement : ses réglages l'interdisent (collect.recordings).
asked-recordings-gone = { $drone } n'a aucun enregistrement de ce relevé.

## Un vol enregistré

film = Film du vol
film-not-live = Enregistrement, pas en direct
film-all = Tous les enregistrements
film-watch = Voir le vol du { $when }
film-reading = Lecture de l'enregistrement…
film-damage = L'enregistrement est abîmé après { $span } :
film-play = Lire
film-pause = Pause
film-time = Temps
film-speed = Vitesse
film-phases = Ce que le drone a fait
film-week = Retour à la semaine
film-before = L'enregistrement d'avant
film-after = L'enregistrement d'après
film-now = { $clock }, { $span }
film-recorded = Enregistré, { $clock }
film-no-picture = Pas encore d'image
film-no-map = L'enregistrement n'a pas de carte
film-map = Carte de l'enregistrement : { $stalls }
film-seen = { $seen ->
        [one] { $seen } place vue à cet instant
       *[other] { $seen } places vues à cet instant
    }
film-seen-of = { $seen } places sur { $all } vues à cet instant
film-values = Batterie, hauteur et distance du départ
film-left = { $time } avant de devoir rentrer
film-from-home = du départ
film-kept = conservé
film-kept-until = conservé jusqu'au { $day }
film-pale = Pâle : pas encore vu

keep-it = Garder
film-gone = Cet enregistrement n’est plus là : il a été supprimé.
ask-part-gone = Le parking n’a ni rangée, ni zone, ni type de ce nom : il s’appelle peut-être autrement maintenant.
address-unread = L’adresse nomme ce qui n’est pas un endroit de cette page, et qui est laissé de côté : { $parts }
compare-same = L’adresse nomme deux fois le même relevé : choisissez-en un autre dans Parkings.
desk-silent-title = Pas de réponse du bureau depuis { $age }
desk-silent-text = Ce qui est montré est peut-être ancien. La page se reconnecte seule.
explore-again-question =
    { $lots ->
        [one] Relever à nouveau le parking ?
       *[other] Relever à nouveau { $lots } parkings ?
    }
explore-again-meaning = { $distance } au-dessus de chaque place connue, dans la géobarrière. Stationnaire l’arrête.

# Les parkings : tous sur une carte et dans un tableau.
all-lots = Tous les parkings
all-lots-map =
    { $lots ->
        [one] Carte de { $lots } parking
       *[other] Carte de { $lots } parkings
    }
all-lots-whole = Montrer tous les parkings
all-lots-search = Chercher
all-lots-order = Ordre
all-lots-by-name = Par nom
all-lots-by-free = Les plus pleins d’abord
all-lots-by-seen = Les plus anciens d’abord
all-lots-in-sight = Seulement les parkings sur la carte
all-lots-report =
    { $lots ->
        [one] Rapport de { $lots } parking
       *[other] Rapport de { $lots } parkings
    }
all-lots-report-most = Un rapport a { $lots } parkings au plus : cherchez-en moins.
all-lots-found = { $lots } parkings sur { $all }
all-lots-more = { $lots } de plus
all-lots-stalls = Places
all-lots-surveys = Relevés
all-lots-seen = Vu le
all-lots-by-due = À relever d’abord
all-lots-by-drone = Par drone
all-lots-drone = Drone
all-lots-due = Relevé dû
all-lots-due-since = depuis { $when }
all-lots-never = jamais
all-lots-free =
    { $free ->
        [one] { $free } libre
       *[other] { $free } libres
    }

# Arrivées
arrivals = Arrivées
arrivals-none = Rien de tel n’est arrivé.
arrivals-more = En montrer plus
arrivals-sender = De
arrivals-outcome = Résultat
arrivals-what = Quoi
arrivals-all = Tous
arrivals-unknown = expéditeur inconnu
arrivals-taken = Pris
arrivals-known = Déjà connu
arrivals-older = Plus ancien que ce qui est ici
arrivals-waits = Le plan vous attend
arrivals-refused = Refusé
arrivals-times = × { $times }
arrivals-kind-survey = Relevé
arrivals-kind-lot = Parking
arrivals-kind-file = Fichier
arrivals-kind-recording = Enregistrement
arrivals-kind-other = Requête
